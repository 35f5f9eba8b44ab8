// The scene of an arm: links, joints, frames, path, obstacles, bodies, and the direction of gravity.
import { plane as isPlane, three as triple } from './arm-geometry.js';

/** {scene, light, pose(q)} of a view, in the frame where gravity points down. */
export function parts(three, view, { colour, variable }) {
  const make = maker(three, variable);
  const scene = new three.Scene();
  const light = new three.DirectionalLight(0xffffff, 2.2);
  const root = new three.Group();
  root.quaternion.setFromRotationMatrix(matrix(three, view.up, [0, 0, 0]));
  scene.add(new three.AmbientLight(0xffffff, 1.3), light, root, ground(make, view));
  if (view.pulled) scene.add(...gravity(make, view));
  const frames = chain(three, make, view, root, colour);
  if (view.path?.length > 1) root.add(make.path(view.path, 0.004 * view.reach, variable('--accent')));
  obstacles(three, make, view.space, view.reach, variable('--warn')).forEach((o) => root.add(o));
  view.shape.forEach(({ joint, from, to, radius }) => frames[joint].add(make.capsule(from, to, radius, variable('--soft'), 0.25)));
  view.bodies.forEach((b) => body(three, make, b, colour(b.joint)).forEach((o) => frames[b.joint].add(o)));
  view.meshes.forEach(({ joint, object }) => (frames[joint] ?? root).add(object));
  if (view.near) root.add(...approach(make, view, variable('--bad')));
  const pose = (q) => frames.forEach((frame, j) => (view.joints[j].kind === 'prismatic' ? frame.position.setZ(q[j]) : frame.rotation.set(0, 0, q[j])));
  return { scene, light, pose };
}

const matrix = (three, r, t) => new three.Matrix4().set(...r[0], t[0], ...r[1], t[1], ...r[2], t[2], 0, 0, 0, 1);

/** Makers of single things; colours as the style sheet has them. */
function maker(three, variable) {
  const vector = (p) => new three.Vector3(...p);
  const solid = (geometry, color, opacity = 1) => new three.Mesh(geometry, new three.MeshLambertMaterial({ color, transparent: opacity < 1, opacity, depthWrite: opacity === 1, side: three.DoubleSide }));
  const along = (object, from, to) => {
    const [a, b] = [vector(from), vector(to)];
    object.position.copy(a).add(b).multiplyScalar(0.5);
    // Cylinders and capsules of three.js stand along y.
    object.quaternion.setFromUnitVectors(new three.Vector3(0, 1, 0), b.sub(a).lengthSq() > 0 ? b.normalize() : new three.Vector3(0, 1, 0));
    return object;
  };
  const length = (from, to) => Math.hypot(...from.map((v, i) => to[i] - v));
  const segments = (points, color, opacity = 1) => new three.LineSegments(new three.BufferGeometry().setFromPoints(points.map(vector)), new three.LineBasicMaterial({ color, transparent: opacity < 1, opacity }));
  return {
    solid, along, segments, variable,
    line: (points, color) => new three.Line(new three.BufferGeometry().setFromPoints(points.map(vector)), new three.LineBasicMaterial({ color })),
    path: (points, radius, color) => solid(new three.TubeGeometry(new three.CatmullRomCurve3(points.map(vector)), Math.min(points.length, 800), radius, 6), color),
    tube: (from, to, radius, color) => along(solid(new three.CylinderGeometry(radius, radius, Math.max(length(from, to), 1e-6), 24), color), from, to),
    cone: (from, to, radius, color) => along(solid(new three.ConeGeometry(radius, length(from, to), 16), color), from, to),
    capsule: (from, to, radius, color, opacity) => along(solid(new three.CapsuleGeometry(Math.max(radius, 1e-4), length(from, to), 8, 20), color, opacity), from, to),
    ball: (at, radius, color, opacity) => { const ball = solid(new three.SphereGeometry(radius, 32, 20), color, opacity); ball.position.set(...at); return ball; },
    edges: (geometry, color) => new three.LineSegments(new three.EdgesGeometry(geometry), new three.LineBasicMaterial({ color })),
    text: (words, at, size) => text(three, words, at, size, variable('--ink')),
  };
}

/** Words that face the viewer; `size` in metres. */
function text(three, words, at, size, ink) {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = 64;
  const context = canvas.getContext('2d');
  context.font = `600 ${words.length > 2 ? 26 : 44}px system-ui, sans-serif`;
  Object.assign(context, { fillStyle: ink, textAlign: 'center', textBaseline: 'middle' });
  context.fillText(words, 32, 34);
  const sprite = new three.Sprite(new three.SpriteMaterial({ map: new three.CanvasTexture(canvas), depthTest: false }));
  sprite.position.set(...at);
  sprite.scale.setScalar(size);
  return sprite;
}

/** Lines every 0.25 m. */
function ground(make, view) {
  const half = Math.ceil(view.reach * 4) / 4;
  const points = [];
  for (let k = -half; k <= half + 1e-9; k += 0.25) points.push([k, -half, 0], [k, half, 0], [-half, k, 0], [half, k, 0]);
  return make.segments(points, make.variable('--line'));
}

/** An arrow beside the arm, down. */
function gravity(make, view) {
  const [side, size] = [0.55 * view.reach, 0.22 * view.reach];
  const at = (z) => [-side, -side, z];
  const whole = make.tube(at(size), at(0.3 * size), 0.008 * view.reach, make.variable('--soft'));
  return [whole, make.cone(at(0.35 * size), at(0), 0.024 * view.reach, make.variable('--soft')), make.text('g', at(1.2 * size), 0.12 * view.reach)];
}

/** One group per joint, each in the one before; what moves with a joint is in its group. */
function chain(three, make, view, root, colour) {
  const thick = view.reach * 0.0275;
  const drawn = new Set(view.meshes.map((m) => m.joint));
  let parent = root;
  return view.joints.map((joint, j) => {
    const fixed = new three.Group();
    fixed.applyMatrix4(matrix(three, joint.rotation, joint.translation));
    if (!drawn.has(j - 1)) parent.add(make.capsule([0, 0, 0], joint.translation, thick * (1 - 0.06 * Math.min(j, 8)), make.variable('--arm') || '#9aa7b4', 1));
    parent.add(fixed);
    const moving = new three.Group();
    fixed.add(moving);
    const height = view.reach * 0.035;
    if (!drawn.has(j)) moving.add(make.tube([0, 0, -height], [0, 0, height], thick * 1.25 * (1 - 0.05 * Math.min(j, 8)), colour(j)));
    moving.add(...axes(make, view, j === view.joints.length - 1));
    if (view.limits) fixed.add(...range(make, view, joint, moving, colour(j)));
    parent = moving;
    return moving;
  });
}

/** x, y and z of a frame in the colours that robotics gives them; those of the last frame have names. */
function axes(make, view, last) {
  const size = view.reach * (last ? 0.12 : 0.07);
  const ends = [[size, 0, 0], [0, size, 0], [0, 0, size]];
  const lines = ends.map((end, i) => make.segments([[0, 0, 0], end], ['#d0342c', '#2c9a3f', '#2f6fd0'][i]));
  return last ? [...lines, ...ends.map((end, i) => make.text('xyz'[i], end.map((v) => 1.2 * v), 0.06 * view.reach))] : lines;
}

/** The range that limits leave a joint: an arc about its axis, or a line along it, and where the joint is. */
function range(make, view, joint, moving, color) {
  if (!joint.position_limits?.every(Number.isFinite)) return [];
  const [low, high] = joint.position_limits;
  if (joint.kind === 'prismatic') return [make.segments([[0, 0, low], [0, 0, high]], color)];
  const radius = 0.11 * view.reach;
  const at = (angle) => [radius * Math.cos(angle), radius * Math.sin(angle), 0];
  const [from, to] = [low, Math.min(high, low + 2 * Math.PI)];
  moving.add(make.segments([[0, 0, 0], at(0)], color));
  return [make.line([[0, 0, 0], ...Array.from({ length: 65 }, (_, i) => at(from + ((to - from) * i) / 64)), [0, 0, 0]], color)];
}

/** Boxes, and a patch of every floor and wall: translucent faces with edges. While a form is filled in, numbers may be missing. */
function obstacles(three, make, space, reach, color) {
  const faced = (geometry, place) => {
    const group = make.solid(geometry, color, 0.18);
    group.add(make.edges(geometry, color));
    place(group);
    return group;
  };
  const boxes = (space?.boxes ?? []).filter((b) => [b.center, b.size].every(triple)).map(({ center, size }) => faced(new three.BoxGeometry(...size), (g) => g.position.set(...center)));
  const planes = (space?.half_spaces ?? []).filter(isPlane).map(({ normal, offset }) => faced(new three.PlaneGeometry(2 * reach, 2 * reach), (g) => {
    const n = new three.Vector3(...normal).normalize();
    g.position.copy(n).multiplyScalar(offset / Math.hypot(...normal));
    g.quaternion.setFromUnitVectors(new three.Vector3(0, 0, 1), n);
  }));
  return [...boxes, ...planes];
}

/** An ellipsoid {joint, centre, shape, label}: `shape` is its half-axes squared as a matrix. A ball mapped by L with L Lᵀ = shape is that ellipsoid. */
function body(three, make, { centre, shape, label }, color) {
  const l = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
  for (let r = 0; r < 3; r += 1) {
    for (let c = 0; c <= r; c += 1) {
      const rest = shape[r][c] - l[r].reduce((sum, v, k) => (k < c ? sum + v * l[c][k] : sum), 0);
      l[r][c] = r === c ? Math.sqrt(Math.max(rest, 1e-8)) : rest / l[c][c];
    }
  }
  const ball = make.ball([0, 0, 0], 1, color, 0.42);
  ball.matrixAutoUpdate = false;
  ball.matrix.copy(matrix(three, l, centre));
  const widest = Math.sqrt(Math.max(shape[0][0], shape[1][1], shape[2][2]));
  return [ball, make.text(label, centre, Math.min(Math.max(1.1 * widest, 0.04), 0.12))];
}

/** Where something comes nearest: a line with a ball at either end. */
function approach(make, view, color) {
  const size = 0.014 * view.reach;
  return [make.tube(view.near[0], view.near[1], 0.5 * size, color), ...view.near.map((p) => make.ball(p, size, color, 1))];
}
