// Where a robot comes from: a file, pasted text, or a table of Denavit-Hartenberg parameters.
import { explain, postJson, send } from './api.js';
import { fill, find, h, labelled, term } from './dom.js';
import { described, markError, unmark } from './field-errors.js';
import { CONVENTIONS, robotOf } from './robot-dh.js';

const RADIANS = Math.PI / 180;

/** `take({description, notes, from})` gets a description by joints, whatever it was given as. */
export function sourceForm(take) {
  const place = h('div');
  const panels = { file: filePanel(place, take), paste: pastePanel(place, take), dh: dhPanel(place, take) };
  const names = { file: 'File', paste: 'Paste', dh: 'DH table' };
  const body = h('div', {}, panels.file);
  const tabs = Object.keys(names).map((key, i) => h('label', { class: 'inline tab' }, h('input', { type: 'radio', name: 'source', value: key, checked: i === 0, onchange: () => { fill(place); fill(body, panels[key]); } }), names[key]));
  return h('section', { class: 'card', id: 'source', 'aria-labelledby': 'source-title' }, h('h2', { id: 'source-title' }, 'Add a robot'),
    h('p', { class: 'soft' }, 'Start from what you have. Everything can be changed in the next step, and nothing is kept before you save it.'),
    h('div', { class: 'row field', role: 'radiogroup', 'aria-label': 'Where the robot comes from' }, tabs), body, place);
}

function filePanel(place, take) {
  const input = h('input', { id: 'source-file', type: 'file', accept: '.urdf,.xml,.mjcf,.json,.zip', 'data-pointer': '/robot', 'data-label': 'The file' });
  const zone = h('div', { class: 'drop field' }, h('label', { for: 'source-file' }, 'URDF, MJCF, JSON or ZIP file'), input,
    h('p', { class: 'help' }, 'Choose a file, or drop it here. A ZIP archive of the robot’s file with its meshes gives the links their shapes; without meshes the file alone will do. xacro files have to be expanded first.'));
  const read = async (file) => file && (await isZip(file) ? archive(place, file, take) : text(place, await file.text(), take));
  // The same file again is read again: it may have been changed meanwhile.
  input.addEventListener('click', () => { input.value = ''; });
  input.addEventListener('change', () => read(input.files[0]));
  zone.addEventListener('dragover', (e) => { e.preventDefault(); zone.classList.add('over'); });
  zone.addEventListener('dragleave', () => zone.classList.remove('over'));
  zone.addEventListener('drop', (e) => { e.preventDefault(); zone.classList.remove('over'); read(e.dataTransfer.files[0]); });
  return zone;
}

function pastePanel(place, take) {
  const area = h('textarea', { id: 'source-text', rows: 10, spellcheck: 'false', class: 'mono', placeholder: '<robot name="my_arm"> …  or  {"name": "my arm", "joints": [ … ]}', 'data-pointer': '/robot', 'data-label': 'The text' });
  return h('div', {}, h('div', { class: 'field' }, h('label', { for: 'source-text' }, 'URDF, MJCF or JSON'), area), h('button', { type: 'button', class: 'primary', onclick: () => text(place, area.value, take) }, 'Read it'));
}

const isZip = async (file) => String.fromCharCode(...new Uint8Array(await file.slice(0, 4).arrayBuffer())) === 'PK\x03\x04';

/** A robot's file with its meshes: the server makes shapes of them. */
async function archive(place, file, take) {
  fill(place, h('p', { class: 'soft', role: 'status' }, 'Reading the archive …'));
  try {
    const answer = await send('/robot-archive', { method: 'POST', headers: { 'content-type': 'application/zip' }, body: file });
    const { document, notes } = await answer.json();
    await show(place, document, notes, take);
  } catch (error) {
    refuse(place, error);
  }
}

/** Says at the field that the robot came from what is wrong, and below it. */
function refuse(place, error) {
  const form = place.parentElement;
  unmark(form);
  const { problem } = error;
  const errors = problem?.errors?.map((e) => ({ ...e, pointer: e.pointer.replace(/^\/robot\/(urdf|mjcf)$/, '/robot') }));
  explain(place, problem ? Object.assign(error, { problem: { ...problem, errors } }) : error, form, { quiet: true });
  if (problem && !errors?.length) markError(form, { pointer: '/robot', detail: problem.detail, hint: problem.hint });
}

/** Reads a document. */
async function text(place, content, take) {
  const xml = content.trimStart().startsWith('<');
  let robot;
  try {
    robot = xml ? { [/<mujoco[\s>]/.test(content) ? 'mjcf' : 'urdf']: content } : JSON.parse(content);
  } catch (error) {
    // Where in the text JSON goes wrong is of use to whoever wrote JSON.
    const json = /^\s*[{[]/.test(content);
    refuse(place, { problem: { detail: json ? `this is no JSON: ${error.message}` : 'this is no description of a robot', hint: json ? undefined : 'choose a URDF or MJCF file (XML), a JSON document, or a ZIP archive of the file with its meshes',
      errors: [{ pointer: '/robot', detail: json ? 'is no JSON that can be read' : 'is neither XML (URDF, MJCF) nor JSON' }] } });
    return;
  }
  await show(place, robot, [], take);
}

/**
 * A document as the editor takes it, by its joints, with remarks on what is another than in the document. Of rows of DH tables it
 * takes what the server makes of them: their bodies stand in other frames.
 */
export function editable(document, description) {
  const rows = document.joints?.some((joint) => joint.dh);
  const remarks = rows ? ['Rows of DH tables are kept as modified parameters (Khalil), with masses and shapes in the frames of these.'] : [];
  return { description: document.joints && !rows ? document : { ...description, effects: document.effects }, remarks };
}

/** Hands a robot on as it is understood, and what of its file was taken: another base or tip is read again. */
async function show(place, robot, remarks, take, part = {}) {
  unmark(place.parentElement);
  fill(place, h('p', { class: 'soft', role: 'status' }, 'Reading …'));
  const chain = chainOf(robot);
  const choice = () => (chain ? chainChoice(chain, part, (other) => show(place, robot, remarks, take, other)) : null);
  try {
    const { description, notes } = await postJson('/motion', { robot: { ...robot, ...part } });
    fill(place);
    const own = editable(robot, description);
    take({ description: own.description, notes: [...remarks, ...own.remarks, ...notes], choice });
  } catch (error) {
    refuse(place, described(error));
    if (chain) place.append(choice());
  }
}

/** From where to where the arm goes in a file: `part` is {base, tip}. Open where the file branches. */
function chainChoice({ names, ends, branches }, part, choose) {
  const select = (key, first, list) => h('select', { id: `source-${key}`, onchange: (e) => choose({ ...part, [key]: e.target.value || undefined }) }, h('option', { value: '' }, first), list.map((name) => h('option', { value: name, selected: name === part[key] }, name)));
  const field = (key, words, help, control) => h('div', { class: 'field' }, labelled(words, `source-${key}`, help), control);
  return h('details', { id: 'chain-part', class: 'field', open: branches || part.base || part.tip ? true : null }, h('summary', {}, 'Part of the file that is the arm'),
    h('div', { class: 'halves' }, field('base', 'Base: link that stands still', 'base_link', select('base', 'the root of the file', names)), field('tip', 'Tip: last link of the chain', 'tip', select('tip', 'the end of the longest chain', [...ends, ...names.filter((n) => !ends.includes(n))]))),
    h('p', { class: 'help' }, branches ? 'The file branches. Choose where the arm ends: the flange, or the link that carries the tool.' : 'Joints outside this part are locked at zero.'));
}

/** Links or bodies of a file, {names, ends, branches}; nothing for a robot that is given by its joints. */
function chainOf({ urdf, mjcf }) {
  if (!urdf && !mjcf) return null;
  const document = new DOMParser().parseFromString(urdf ?? mjcf, 'application/xml');
  const all = (selector, attribute = 'name', of = document) => [...of.querySelectorAll(selector)].map((e) => e.getAttribute(attribute)).filter(Boolean);
  const names = urdf ? all('robot > link') : all('worldbody body');
  const parents = new Set(urdf ? all('robot > joint > parent', 'link') : names.filter((name) => all(`body[name="${CSS.escape(name)}"] body`).length));
  const ends = names.filter((name) => !parents.has(name));
  return names.length > 1 ? { names, ends, branches: ends.length > 1 } : null;
}

function dhPanel(place, take) {
  const name = h('input', { id: 'dh-name', value: 'my arm' });
  const count = h('input', { id: 'dh-count', type: 'number', min: 1, max: 32, value: 6 });
  const convention = h('select', { id: 'dh-convention' }, Object.entries(CONVENTIONS).map(([key, c]) => h('option', { value: key }, c.name)));
  const degrees = h('select', { id: 'dh-unit' }, h('option', { value: 'deg' }, 'degrees'), h('option', { value: 'rad' }, 'radians'));
  const help = h('p', { class: 'help' });
  const grid = h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'DH table' });
  const rows = [];
  const value = (row, key) => row[key] ?? '0';
  const draw = () => {
    const { columns, help: words } = CONVENTIONS[convention.value];
    const wanted = Math.min(Math.max(Math.round(Number(count.value)) || 1, 1), 32);
    while (rows.length < wanted) rows.push({ name: `J${rows.length + 1}`, kind: 'revolute' });
    rows.length = wanted;
    help.textContent = words;
    const unit = degrees.value === 'deg' ? '°' : 'rad';
    const heads = ['Joint', 'Kind', ...columns.map(([, shown, angle]) => `${shown} (${angle ? unit : 'm'})`)];
    const cell = (row, j, [key, shown]) => h('td', {}, h('input', { class: 'cell-number', value: value(row, key), inputmode: 'decimal', 'aria-label': `${row.name} ${shown}`, 'data-row': j, 'data-key': key, oninput: (e) => { row[key] = e.target.value; } }));
    const line = (row, j) => h('tr', {}, h('td', {}, h('input', { class: 'cell-name', value: row.name, 'aria-label': `Name of joint ${j + 1}`, 'data-pointer': `/robot/joints/${j}/name`, oninput: (e) => { row.name = e.target.value; } })),
      h('td', {}, h('select', { class: 'narrow', 'aria-label': `Kind of joint ${j + 1}`, onchange: (e) => { row.kind = e.target.value; } }, ['revolute', 'prismatic'].map((k) => h('option', { value: k, selected: row.kind === k }, k)))), columns.map((c) => cell(row, j, c)));
    fill(grid, h('table', { class: 'few' }, h('thead', {}, h('tr', {}, heads.map((t) => h('th', { scope: 'col' }, t === 'Joint' ? t : term(t === 'Kind' ? 'joint_kind' : 'dh_convention', t))))), h('tbody', {}, rows.map(line))));
  };
  [count, convention, degrees].forEach((e) => e.addEventListener('change', draw));
  draw();
  const go = async () => {
    const bad = [];
    const read = (row, j, [key, shown, angle]) => {
      const number = expression(value(row, key));
      if (!Number.isFinite(number)) bad.push(`${row.name}: ${shown} is “${value(row, key)}”, expected a number`);
      return [key, angle && degrees.value === 'deg' ? number * RADIANS : number];
    };
    const { columns } = CONVENTIONS[convention.value];
    const numbers = rows.map((row, j) => ({ name: row.name, kind: row.kind, ...Object.fromEntries(columns.map((c) => read(row, j, c))) }));
    if (bad.length) {
      fill(place, h('div', { class: 'problem', role: 'alert' }, h('strong', {}, 'Some entries are not numbers.'), h('ul', {}, bad.map((b) => h('li', {}, b)))));
      return;
    }
    await text(place, JSON.stringify(robotOf(name.value, numbers, convention.value)), take);
  };
  return h('div', {}, h('div', { class: 'halves' }, h('div', { class: 'field' }, h('label', { for: 'dh-name' }, 'Name'), name), h('div', { class: 'field' }, h('label', { for: 'dh-count' }, 'Joints'), count),
    h('div', { class: 'field' }, labelled('Convention', 'dh-convention', 'dh_convention'), convention), h('div', { class: 'field' }, h('label', { for: 'dh-unit' }, 'Angles in'), degrees)), help, grid,
  h('p', { class: 'help' }, 'θ (or, for a prismatic joint, d) is the offset that the joint’s own position is added to. Numbers may be written as 0.5, 1/2, pi/2 or -90.'), h('div', { class: 'actions' }, h('button', { type: 'button', class: 'primary', onclick: go }, 'Use this table')));
}

/** A number as people write it in a table: `-0.5`, `pi/2`, `-3*pi/4`, `1/2`; NaN for anything else. */
export function expression(text) {
  const parts = text.trim().replaceAll('−', '-').replaceAll('π', 'pi').toLowerCase().split(/([*/])/).map((p) => p.trim());
  const factor = (part) => {
    const match = /^([+-]?)(pi|\d+\.?\d*(?:e[+-]?\d+)?|\.\d+)$/.exec(part);
    if (!match) return NaN;
    return (match[1] === '-' ? -1 : 1) * (match[2] === 'pi' ? Math.PI : Number(match[2]));
  };
  let value = factor(parts[0]);
  for (let i = 1; i < parts.length; i += 2) value = parts[i] === '*' ? value * factor(parts[i + 1] ?? '') : value / factor(parts[i + 1] ?? '');
  return value;
}
