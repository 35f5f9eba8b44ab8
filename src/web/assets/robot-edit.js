// The editor of a robot description: every field of it, drawn while it changes.
import { ArmView, HOW_TO_TURN } from './arm.js';
import { explain, getJson, postJson, send } from './api.js';
import { shapeOf, startOf } from './cell-view.js';
import { breakable, fill, find, h, labelled, mark, said, sentence, term } from './dom.js';
import { described, unmark } from './field-errors.js';
import { jointDetails, suggestShape } from './robot-joint.js';
import { RobotEffects } from './robot-effects.js';
import { Fields } from './robot-fields.js';
import { toolForm } from './robot-tool.js';

const MOUNTINGS = [['On the floor', [0, 0, -9.81]], ['Hanging from the ceiling', [0, 0, 9.81]], ['On a wall: gravity along +x', [9.81, 0, 0]], ['On a wall: gravity along −x', [-9.81, 0, 0]],
  ['On a wall: gravity along +y', [0, 9.81, 0]], ['On a wall: gravity along −y', [0, -9.81, 0]], ['No gravity', [0, 0, 0]]];

/** Edits `start.description`. `id`: under which it is kept, null for a new robot; `saved(id)` when it is. */
export function editor({ id, start, saved, cancel }) {
  const fields = new Fields(structuredClone(start.description), () => soon());
  const shaped = (doc) => doc.joints.some((joint) => joint.geometry?.length);
  const suggested = !id && !shaped(fields.doc) && (suggestShape(fields.doc), shaped(fields.doc));
  const remarks = [...(start.notes ?? []), ...(suggested ? ['The description has no shape. Capsules along the links are suggested, so that designs avoid self-collision and the floor: check them in the picture.'] : [])];
  const form = h('form', { id: 'editor', class: 'card', novalidate: true, 'aria-labelledby': 'editor-title' });
  const notes = h('div');
  const trouble = h('div', { 'data-role': 'trouble' });
  const name = h('input', { id: 'robot-id', value: id ?? slug(fields.doc.name), autocomplete: 'off', spellcheck: 'false' });
  const picture = preview();
  const effects = new RobotEffects(fields);
  const draw = () => keepOpen(form, () => fill(form, h('h2', { id: 'editor-title' }, id ? `Edit ${fields.doc.name}` : 'Describe the robot'), notes, start.choice?.(),
    general(fields), joints(fields, draw), h('div', { class: 'row spread' }, h('h3', {}, 'Links, ', term('capsule', 'shapes'), ' and bounds'), h('button', { type: 'button', onclick: () => { suggestShape(fields.doc); draw(); fields.changed(); } }, 'Suggest a shape')), fields.doc.joints.map((_, j) => jointDetails(fields, j, draw)), toolForm(fields, draw), (effects.read(), effects.element), asJson(fields, draw),
    h('div', { class: 'field' }, labelled('ID', 'robot-id', 'id'), (name.disabled = Boolean(id), name), h('p', { class: 'help' }, 'Names the robot in requests and addresses: letters, digits, - and _.')), trouble,
    h('div', { class: 'actions' }, h('button', { class: 'primary' }, 'Save robot'), h('button', { type: 'button', onclick: cancel }, 'Cancel'))));
  form.addEventListener('submit', async (event) => {
    event.preventDefault();
    unmark(form);
    fill(trouble);
    try {
      await postJson('/motion', { robot: fields.doc });
      const path = id || name.value ? `/robots/${encodeURIComponent(name.value)}` : '/robots';
      await keep(path, fields.doc, Boolean(id));
      saved(name.value);
    } catch (error) {
      explain(trouble, described(error), form);
    }
  });
  const say = (more) => fill(notes, [...new Set([...remarks, ...more])].map((n) => h('div', { class: 'notice' }, h('p', {}, said(sentence(n))))));
  let waiting = null;
  const soon = () => { clearTimeout(waiting); waiting = setTimeout(check, 350); };
  async function check() {
    effects.follow();
    try {
      const drawn = await postJson('/motion', { robot: fields.doc });
      unmark(form);
      fill(trouble);
      say(drawn.notes);
      await picture.show(fields.doc, drawn);
    } catch (error) {
      unmark(form);
      explain(trouble, described(error), form, { quiet: true });
    }
  }
  draw();
  say([]);
  check();
  return h('div', { class: 'editor' }, form, picture.element);
}

/** Draws a form anew; the parts that were open stay so. */
function keepOpen(form, draw) {
  const open = [...form.querySelectorAll('details[open][id]')].map((part) => part.id);
  draw();
  open.forEach((part) => find(`#${part}`, form)?.setAttribute('open', ''));
}

/** Keeps a robot; a new one does not take the place of another without a word. */
async function keep(path, robot, replace) {
  const id = path.split('/')[2];
  if (!replace && id) {
    const { robots } = await getJson('/robots');
    const there = robots.some((r) => r.id === decodeURIComponent(id));
    if (there && !confirm(`There is a robot ${id} already. Replace it?`)) throw Object.assign(new Error(), { problem: { detail: `There is a robot ${id} already.`, hint: 'Choose another ID.' } });
  }
  await send(path, { method: id ? 'PUT' : 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(robot) });
}

/** As the interface makes an ID of a name. */
const slug = (name) => (name ?? '').toLowerCase().replaceAll(/[^a-z0-9_]+/g, '-').replaceAll(/^-+|-+$/g, '').slice(0, 64);

function general(fields) {
  const gravity = fields.doc.gravity ?? [0, 0, -9.81];
  fields.doc.gravity = gravity;
  const inputs = ['x', 'y', 'z'].map((axis, i) => fields.number(['gravity', i], { label: `Gravity ${axis}`, required: true }));
  const known = MOUNTINGS.findIndex(([, g]) => g.every((v, i) => v === gravity[i]));
  const mounting = h('select', { id: 'mounting', onchange: () => {
    const g = MOUNTINGS[mounting.value]?.[1];
    if (g) g.forEach((v, i) => { inputs[i].value = v; inputs[i].dispatchEvent(new Event('input')); });
  } }, MOUNTINGS.map(([name], i) => h('option', { value: i, selected: i === known }, name)), h('option', { value: '', selected: known < 0 }, 'As entered'));
  const friction = (kind, words) => {
    const list = () => fields.doc.friction ?? ['viscous', 'coulomb'];
    return h('label', { class: 'inline' }, h('input', { type: 'checkbox', checked: list().includes(kind), onchange: (e) => { fields.doc.friction = e.target.checked ? [...list(), kind] : list().filter((f) => f !== kind); fields.changed(); } }), words);
  };
  return h('div', {}, h('div', { class: 'halves' }, h('div', { class: 'field' }, h('label', { for: 'robot-name' }, 'Name'), fields.text(['name'], { id: 'robot-name' })), h('div', { class: 'field' }, labelled('Mounting', 'mounting', 'mounting'), mounting)),
    h('div', { class: 'field', role: 'group', 'aria-label': 'Gravity in the base frame' }, h('span', { class: 'label' }, 'Gravity in the base frame (m/s²)'), h('div', { class: 'three' }, inputs)),
    h('div', { class: 'row field', 'data-pointer': '/robot/friction', 'data-label': 'Friction' }, h('span', { class: 'label' }, term('friction', 'Friction'), ' of every joint'), friction('viscous', 'viscous'), friction('coulomb', 'Coulomb')),
    h('div', { class: 'field' }, h('span', { class: 'labelled' }, h('label', { for: 'robot-source' }, 'Source of the description'), mark('source', 'Source')), fields.sourceInput([], { id: 'robot-source' })));
}

/** Heads that are terms, without their units. */
const HEADS = { Kind: 'joint_kind', α: 'dh_convention', d: 'dh_convention', θ: 'dh_convention', r: 'dh_convention', roll: 'roll_pitch_yaw', pitch: 'roll_pitch_yaw', yaw: 'roll_pitch_yaw', 'axis x': 'joint_axis', jerk: 'jerk' };
const termOf = (head) => HEADS[head.split(' (')[0]];
const LIMITS = [['velocity', 'velocity', '/s'], ['acceleration', 'acceleration', '/s²'], ['jerk', 'jerk', '/s³']];

function joints(fields, draw) {
  const all = fields.doc.joints;
  const dh = all.every((joint) => joint.mdh);
  const angle = h('select', { id: 'angle-unit', class: 'narrow', onchange: () => { fields.degrees = angle.value === 'deg'; draw(); } }, [['rad', 'radians'], ['deg', 'degrees']].map(([k, t]) => h('option', { value: k, selected: (k === 'deg') === fields.degrees }, t)));
  const turning = all.some((joint) => joint.kind !== 'prismatic');
  const unit = turning ? fields.angle : 'm';
  const kind = (joint, j) => h('select', { class: 'narrow', 'aria-label': `${joint.name}: kind`, 'data-pointer': `/robot/joints/${j}/kind`, onchange: (e) => { joint.kind = e.target.value; draw(); fields.changed(); } }, ['revolute', 'prismatic'].map((k) => h('option', { value: k, selected: joint.kind === k }, k)));
  const cell = (input) => h('td', {}, h('div', { class: 'field' }, input));
  const number = (j, path, label, options) => cell(fields.number(['joints', j, ...path], { label: `${all[j].name}: ${label}`, cell: true, ...options }));
  const placement = (joint, j) => {
    if (dh) return [['alpha', true], ['d', false], ['theta', true], ['r', false]].map(([key, turn]) => number(j, ['mdh', key], key, { angle: turn, required: true }));
    joint.placement ??= {};
    const of = (part, label, turn) => ['0', '1', '2'].map((i) => number(j, ['placement', part, Number(i)], `${label} ${'xyz'[i]}`, { angle: turn, otherwise: part === 'axis' ? [0, 0, 1] : [0, 0, 0] }));
    return joint.mdh ? [h('td', { colspan: 9, class: 'soft' }, 'placed by DH parameters')] : [...of('xyz', 'position', false), ...of('rpy', 'roll pitch yaw', true), ...of('axis', 'axis', false)];
  };
  const heads = dh ? [`α (${fields.angle})`, 'd (m)', `θ (${fields.angle})`, 'r (m)'] : ['x (m)', 'y', 'z', `roll (${fields.angle})`, 'pitch', 'yaw', 'axis x', 'y', 'z'];
  const row = (joint, j) => h('tr', {}, cell(fields.text(['joints', j, 'name'], { label: `Name of joint ${j + 1}`, cell: true })), h('td', {}, kind(joint, j)), placement(joint, j),
    h('td', {}, h('button', { type: 'button', class: 'quiet', 'aria-label': `Remove ${joint.name}`, disabled: all.length === 1, onclick: () => { all.splice(j, 1); draw(); fields.changed(); } }, '✕')));
  const limits = (joint, j) => {
    joint.limits ??= {};
    const turn = { angle: joint.kind !== 'prismatic' };
    return h('tr', {}, h('th', { scope: 'row' }, breakable(joint.name ?? '')), [0, 1].map((end) => number(j, ['limits', 'position', end], ['lowest position', 'highest position'][end], { ...turn, pair: true })), LIMITS.map(([key, words]) => number(j, ['limits', key], words, turn)), number(j, ['limits', 'effort'], joint.kind === 'prismatic' ? 'force' : 'torque', {}));
  };
  const table = (label, head, rows) => h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': label }, h('table', { class: 'entry' }, h('thead', {}, h('tr', {}, head.map((t) => h('th', { scope: 'col' }, t === 'Remove' ? h('span', { class: 'unseen' }, t) : termOf(t) ? term(termOf(t), t) : t)))), h('tbody', {}, rows)));
  const add = () => {
    const number = all.length + 1;
    all.push({ name: `J${number}`, kind: 'revolute', ...(dh ? { mdh: { alpha: 0, d: 0, theta: 0, r: 0 } } : { placement: { xyz: [0, 0, 0.1] } }), limits: {} });
    draw();
    fields.changed();
  };
  return h('div', {}, h('div', { class: 'row spread' }, h('h3', {}, 'Joints'), h('label', { class: 'inline', for: 'angle-unit' }, 'Angles in', angle)),
    h('p', { class: 'help' }, dh ? 'Modified DH parameters (Khalil; Craig’s a is d here, and his d is r).' : 'Pose of each joint in the link before it, as in a URDF file.'),
    table('Placement of the joints', ['Joint', 'Kind', ...heads, 'Remove'], all.map(row)), h('div', { class: 'actions' }, h('button', { type: 'button', onclick: add }, 'Add joint')),
    h('h3', {}, 'Joint limits'), h('p', { class: 'help' }, `Angles in ${fields.degrees ? 'degrees' : 'radians'}; N·m, for prismatic joints m and N. Empty: not limited.`),
    table('Joint limits', ['Joint', `from (${unit})`, 'to', ...LIMITS.map(([, words, per]) => `${words} (${unit}${per})`), 'torque (N·m)'], all.map(limits)));
}

function asJson(fields, draw) {
  const area = h('textarea', { rows: 12, class: 'mono', spellcheck: 'false', id: 'as-json', 'aria-label': 'The description as JSON' });
  const place = h('div');
  const take = () => {
    try {
      fields.doc = JSON.parse(area.value);
      if (!Array.isArray(fields.doc?.joints) || !fields.doc.joints.length) throw new Error('it has no joints');
      draw();
      fields.changed();
    } catch (error) {
      fill(place, h('p', { class: 'field-error', role: 'alert' }, `This cannot be used: ${error.message}`));
    }
  };
  return h('details', { id: 'json-part', ontoggle: (e) => { if (e.target.open) area.value = JSON.stringify(fields.doc, null, 2); } }, h('summary', {}, 'As JSON'), h('p', { class: 'help' }, 'The whole description, sources included. What is changed here goes into the fields above.'), area, place,
    h('div', { class: 'actions' }, h('button', { type: 'button', onclick: take }, 'Use this text')));
}

/** The arm as it is described just now. */
function preview() {
  const canvas = h('canvas', { class: 'arm', 'aria-label': 'The robot as it is described. Arrow keys turn the view.' });
  let view = null;
  return {
    element: h('aside', { class: 'card picture', 'aria-label': 'Picture' }, canvas, h('p', { class: 'help' }, `Grid 0.25 m; the arrow g is gravity. Arcs are the ranges of the joints, capsules the shape that keeps clear of obstacles. ${HOW_TO_TURN}`)),
    async show(doc, drawn) {
      view ??= new ArmView(canvas, drawn.joints, drawn.gravity);
      view.replace(drawn.joints, drawn.gravity);
      view.shape = await shapeOf(doc, drawn.joints);
      view.limits = true;
      view.q = startOf(drawn.joints);
      view.frameCell();
      view.draw();
    },
  };
}
