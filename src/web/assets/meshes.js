// Meshes of a robot's links, to look at: they stay in this browser, and no calculation uses them.
import { transposed, UNIT } from './arm-geometry.js';
import { fill, h } from './dom.js';
import { variable } from './plot.js';

const STORE = 'meshes';

function opened() {
  return new Promise((done, failed) => {
    const asked = indexedDB.open('dynident', 1);
    asked.onupgradeneeded = () => asked.result.createObjectStore(STORE);
    asked.onsuccess = () => done(asked.result);
    asked.onerror = () => failed(asked.error);
  });
}

async function kept(robot, value) {
  const store = (await opened()).transaction(STORE, value === undefined ? 'readonly' : 'readwrite').objectStore(STORE);
  const asked = value === undefined ? store.get(robot) : value ? store.put(value, robot) : store.delete(robot);
  return new Promise((done, failed) => { asked.onsuccess = () => done(asked.result); asked.onerror = () => failed(asked.error); });
}

/** {joint, object} of every mesh that is kept for a robot; `joint` is −1 for the base. */
export async function meshesOf(robot, drawn) {
  if (typeof robot !== 'string') return [];
  const list = (await kept(robot).catch(() => null)) ?? [];
  if (!list.length) return [];
  const three = await import('/assets/three.js');
  const placed = list.filter((m) => m.joint < drawn.joints.length).map(async (mesh) => ({ joint: mesh.joint, object: await objectOf(three, mesh, drawn) }));
  return (await Promise.all(placed.map((p) => p.catch(() => null)))).filter(Boolean);
}

async function objectOf(three, mesh, drawn) {
  const shape = await parsed(three, mesh);
  const holder = new three.Group();
  const rows = (r) => new three.Matrix4().set(...r[0], 0, ...r[1], 0, ...r[2], 0, 0, 0, 0, 1);
  // From the frame of the description to that of the joint, and in it where the URDF puts the mesh.
  holder.applyMatrix4(rows(mesh.joint < 0 ? UNIT : transposed(drawn.joints[mesh.joint].description_frame)));
  const inner = new three.Group();
  mesh.origins.forEach(({ xyz, rpy }) => inner.matrix.multiply(new three.Matrix4().makeTranslation(...xyz)).multiply(turn(three, rpy)));
  inner.matrix.scale(new three.Vector3(...mesh.scale));
  inner.matrixAutoUpdate = false;
  inner.add(shape);
  holder.add(inner);
  return holder;
}

/** Rot z(yaw) · Rot y(pitch) · Rot x(roll). */
const turn = (three, [roll, pitch, yaw]) => new three.Matrix4().makeRotationZ(yaw).multiply(new three.Matrix4().makeRotationY(pitch)).multiply(new three.Matrix4().makeRotationX(roll));

async function parsed(three, { name, bytes }) {
  if (/\.stl$/i.test(name)) {
    const geometry = new three.STLLoader().parse(bytes);
    if (!geometry.getAttribute('position')?.count) throw new Error('it holds no triangles');
    // Some programs write zeros for normals.
    geometry.computeVertexNormals();
    return new three.Mesh(geometry, new three.MeshLambertMaterial({ color: variable('--arm') || '#9aa7b4', side: three.DoubleSide }));
  }
  const loader = new three.GLTFLoader();
  // Pictures on surfaces would be fetched from blobs, which the pages do not allow; shapes are what is looked at.
  loader.register(() => ({ name: 'without-textures', loadTexture: () => Promise.resolve(new three.Texture()) }));
  return (await loader.parseAsync(bytes, '')).scene;
}

/** Link and place of every mesh file that a URDF names: {file: [{joint, origins, scale}]}. */
function placesIn(urdf, joints) {
  const robot = new DOMParser().parseFromString(urdf, 'application/xml').querySelector('robot');
  const numbers = (text, otherwise) => (text?.trim().split(/\s+/).map(Number) ?? otherwise);
  const origin = (parent) => { const o = [...(parent?.children ?? [])].find((c) => c.tagName === 'origin'); return { xyz: numbers(o?.getAttribute('xyz'), [0, 0, 0]), rpy: numbers(o?.getAttribute('rpy'), [0, 0, 0]) }; };
  const above = new Map([...(robot?.children ?? [])].filter((c) => c.tagName === 'joint').map((j) => [j.querySelector('child')?.getAttribute('link'), { link: j.querySelector('parent')?.getAttribute('link'), name: j.getAttribute('name'), origin: origin(j) }]));
  const carried = (link, way = []) => {
    const up = above.get(link);
    const joint = joints.findIndex((j) => j.name === up?.name);
    // Fixed joints are part of the link before them.
    return joint >= 0 || !up || way.length > 100 ? { joint, way } : carried(up.link, [up.origin, ...way]);
  };
  const found = new Map();
  for (const visual of robot?.querySelectorAll('link > visual') ?? []) {
    const mesh = visual.querySelector('geometry > mesh');
    const file = mesh?.getAttribute('filename')?.split('/').at(-1);
    if (!file) continue;
    const { joint, way } = carried(visual.parentElement.getAttribute('name'));
    found.set(file, [...(found.get(file) ?? []), { joint, origins: [...way, origin(visual)], scale: numbers(mesh.getAttribute('scale'), [1, 1, 1]) }]);
  }
  return found;
}

/** Without a URDF: by the name of the joint in that of the file, or its last number. */
function placeByName(file, joints) {
  const stem = file.replace(/\.\w+$/, '').toLowerCase();
  const named = joints.findIndex((j) => stem.includes(j.name.toLowerCase()));
  const number = Number(/(\d+)\D*$/.exec(stem)?.[1]);
  const joint = named >= 0 ? named : number >= 1 && number <= joints.length ? number - 1 : /base|link_?0$/.test(stem) ? -1 : null;
  return joint === null ? [] : [{ joint, origins: [], scale: [1, 1, 1] }];
}

/** The part of the robot page that takes meshes; `changed(meshes)` after every change. */
export function meshPart(robot, drawn, changed) {
  const input = h('input', { id: 'mesh-files', type: 'file', multiple: true, accept: '.stl,.glb,.gltf,.urdf,.xml' });
  const status = h('div', { role: 'status' });
  const away = h('button', { type: 'button', onclick: () => kept(robot.id, null).then(() => { fill(status, h('p', {}, 'Removed.')); changed([]); }) }, 'Remove all meshes');
  input.addEventListener('change', () => take([...input.files]).catch((e) => fill(status, h('p', { class: 'field-error', role: 'alert' }, `The meshes cannot be used: ${e.message}`))));
  async function take(files) {
    const urdf = files.find((f) => /\.(urdf|xml)$/i.test(f.name));
    const places = urdf ? placesIn(await urdf.text(), drawn.joints) : null;
    const three = await import('/assets/three.js');
    const [list, problems] = [(await kept(robot.id)) ?? [], []];
    for (const file of files.filter((f) => f !== urdf)) {
      const known = places?.get(file.name) ?? placeByName(file.name, drawn.joints);
      const bytes = await file.arrayBuffer();
      const wrong = !/\.(stl|glb|gltf)$/i.test(file.name) ? 'is neither STL nor glTF' : !known.length ? 'names no joint of this robot; give the URDF file as well' : await parsed(three, { name: file.name, bytes }).then(() => null, (e) => `cannot be read: ${e.message}`);
      if (wrong) problems.push(`${file.name} ${wrong}.`);
      else list.splice(0, list.length, ...list.filter((m) => m.name !== file.name), ...known.map((place) => ({ ...place, name: file.name, bytes })));
    }
    await kept(robot.id, list);
    fill(status, h('p', {}, `${list.length} mesh${list.length === 1 ? '' : 'es'} kept in this browser.`), problems.map((p) => h('p', { class: 'field-error' }, p)));
    changed(await meshesOf(robot.id, drawn));
  }
  return h('details', { id: 'meshes' }, h('summary', {}, 'Meshes'), h('label', { for: 'mesh-files' }, 'STL or glTF files of the links, and the URDF file that places them'), input,
    h('p', { class: 'help' }, 'Without a URDF file, the name of a file says its joint, and its origin is that of the link. Meshes are for looking only and stay in this browser; capsules keep the arm clear of obstacles.'), status, away);
}
