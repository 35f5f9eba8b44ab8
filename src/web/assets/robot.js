// Robot: kinematics to move, limits, base parameters, designs and identifications over time.
import { ArmView, HOW_TO_TURN, poses } from './arm.js';
import { download, explain, getJson, postJson, send, summaryOf } from './api.js';
import { shapeOf } from './cell-view.js';
import { meshesOf, meshPart } from './meshes.js';
import { fill, find, h, measured, number, perSecond, said, sentence, table, term, time, unit, words } from './dom.js';
import { editor } from './robot-edit.js';
import { effectTable } from './robot-effects.js';
import { searchEnd } from './job-words.js';
import { editable, sourceForm } from './robot-source.js';
import { nameOf, typeset } from './expression.js';
import { colour, plot, plotLater } from './plot.js';

/** Opens a description to be changed; `start` as the sources hand it over. */
function edit(id, start) {
  const target = find('#result');
  const back = () => { location.href = id ? address(id) : '/robot'; };
  fill(target, editor({ id, start, saved: (kept) => { location.href = address(kept); }, cancel: back }));
  target.scrollIntoView({ block: 'start' });
}

const address = (id) => `/robot?robot=${encodeURIComponent(id)}`;

function addRobot() {
  fill(find('#result'), sourceForm((start) => edit(null, start)));
}

/** A kept robot, or a copy of one that comes with the program, by its joints. */
async function editKept(robot) {
  const document = await getJson(`/robots/${encodeURIComponent(robot.id)}`);
  const { description, notes } = await postJson('/motion', { robot: document });
  const { description: own, remarks: changed } = editable(document, description);
  const remarks = document.urdf || document.mjcf ? ['This robot was given as a URDF or MJCF file. Saved here, it is kept by its joints, with all that was read of the file.', ...notes] : [...changed, ...notes];
  if (!robot.shipped) return edit(robot.id, { description: own, notes: remarks });
  return edit(null, { description: { ...own, name: `${own.name} (copy)` }, notes: ['Robots that come with the program stay as they are; this is a copy.', ...remarks] });
}

const section = (id, title, ...parts) => h('section', { class: 'card', id, 'aria-labelledby': `${id}-title` }, h('h2', { id: `${id}-title` }, title), parts);

async function show(robot) {
  const target = find('#result');
  const drawn = await postJson('/motion', { robot: robot.id });
  const base = h('div', {}, h('p', { class: 'soft' }, 'Computing …'));
  const history = h('div', {}, h('p', { class: 'soft' }, 'Looking …'));
  const own = h('div');
  const parts = [['kinematics', 'Kinematics'], ['limits', 'Limits'], ['base', 'Base parameters'], ['history', 'History']];
  fill(target, h('nav', { class: 'toc', 'aria-label': 'Parts' }, parts.map(([id, name]) => h('a', { href: `#${id}` }, name))),
    drawn.notes.length ? h('div', { class: 'notice' }, drawn.notes.map((n) => h('p', {}, said(sentence(n))))) : null,
    kinematics(robot, drawn), limits(drawn), own, section('base', [term('base_parameters', 'Base parameters')], base), section('history', 'Designs and identifications', history));
  getJson(`/robots/${encodeURIComponent(robot.id)}/base-parameters`).then((b) => fill(base, baseTable(b))).catch((e) => explain(base, e));
  showEffects(own, robot).catch((e) => explain(own, e));
  showHistory(history, robot).catch((e) => explain(history, e));
}

/** Own effects of the robot, where it has some. */
async function showEffects(place, robot) {
  const shown = robot.shipped ? null : await effectTable(await getJson(`/robots/${encodeURIComponent(robot.id)}`));
  fill(place, shown ? section('own', [term('own_effect', 'Own effects')], shown) : null);
}

function kinematics(robot, drawn) {
  const canvas = h('canvas', { class: 'arm', 'aria-label': `${drawn.robot}: the arm as its joints are set. Arrow keys turn the view.` });
  const view = new ArmView(canvas, drawn.joints, drawn.gravity);
  view.limits = true;
  const clothe = (meshes) => { view.meshes = meshes; view.draw(); };
  meshesOf(robot.id, drawn).then(clothe);
  shapeOf(robot.id, drawn.joints).then((shape) => { view.shape = shape; view.draw(); });
  const place = h('output', { class: 'mono', 'aria-live': 'off' });
  const q = drawn.joints.map((j) => start(j));
  const update = () => {
    view.set([...q]);
    const end = poses(drawn.joints, q).at(-1).position;
    place.textContent = `last frame at ${end.map((v) => number(v, 3)).join(', ')} m`;
  };
  const sliders = drawn.joints.map((joint, j) => slider(joint, q[j], (v) => { q[j] = v; update(); }));
  const zero = h('button', { type: 'button', onclick: () => sliders.forEach((s, j) => s.set(start(drawn.joints[j]))) }, 'Back to zero');
  queueMicrotask(update);
  const actions = h('div', { class: 'row field' }, h('a', { class: 'button primary', href: `/design?robot=${encodeURIComponent(robot.id)}` }, 'Design a trajectory'), h('a', { class: 'button', href: `/identification?robot=${encodeURIComponent(robot.id)}` }, 'Identify'),
    h('button', { type: 'button', onclick: () => editKept(robot).catch((e) => explain(find('#trouble'), e)) }, robot.shipped ? 'Edit a copy' : 'Edit'),
    download('Description (JSON)', `/robots/${robot.id}`, `${robot.id}.json`), robot.shipped ? null : forget(robot));
  return section('kinematics', drawn.robot, actions, h('div', { class: 'columns', style: 'grid-template-columns:repeat(auto-fit,minmax(min(100%,20rem),1fr))' }, h('div', {}, canvas, h('p', { class: 'help' }, `Grid 0.25 m; the arrow g is gravity; arcs are the ranges of the joints. ${HOW_TO_TURN}`)), h('div', {}, h('div', { class: 'sliders' }, sliders.map((s) => s.element)), h('div', { class: 'row spread' }, place, zero))), meshPart(robot, drawn, clothe));
}

function forget(robot) {
  return h('button', { type: 'button', onclick: async () => {
    if (!confirm(`Delete the robot ${robot.id}? Its designs and identifications stay.`)) return;
    await send(`/robots/${encodeURIComponent(robot.id)}`, { method: 'DELETE' }).then(() => { location.href = '/'; }, (e) => explain(find('#trouble'), e));
  } }, 'Delete');
}

const span = (joint) => joint.position_limits ?? (joint.kind === 'prismatic' ? [-0.5, 0.5] : [-Math.PI, Math.PI]);
const start = (joint) => (span(joint)[0] <= 0 && span(joint)[1] >= 0 ? 0 : (span(joint)[0] + span(joint)[1]) / 2);

function slider(joint, value, tell) {
  const [low, high] = span(joint);
  const id = `joint-${joint.name}`.replace(/\W/g, '-');
  const output = h('output', { class: 'number', for: id });
  const input = h('input', { id, type: 'range', min: low, max: high, step: (high - low) / 500 });
  const set = (v) => {
    input.value = v;
    output.textContent = `${number(Number(input.value), 3)} ${joint.position_unit}`;
    tell(Number(input.value));
  };
  input.addEventListener('input', () => set(input.value));
  input.value = value;
  output.textContent = `${number(value, 3)} ${joint.position_unit}`;
  return { set, element: h('div', { class: 'slider' }, h('label', { for: id }, joint.name), input, output) };
}

function limits(drawn) {
  const bound = (value, text) => (value === null ? '–' : `${number(value)} ${text}`);
  return section('limits', 'Joints and limits', table([
    { head: 'Joint', cell: (j) => j.name, sort: (j) => j.name }, { head: 'Kind', term: 'joint_kind', cell: (j) => j.kind },
    { head: 'Position', number: true, cell: (j) => (j.position_limits ? `${number(j.position_limits[0])} … ${number(j.position_limits[1])} ${j.position_unit}` : '–') },
    { head: 'Velocity', number: true, cell: (j) => bound(j.velocity_limit, perSecond(j.position_unit, 1)), sort: (j) => j.velocity_limit }, { head: 'Acceleration', number: true, cell: (j) => bound(j.acceleration_limit, perSecond(j.position_unit, 2)), sort: (j) => j.acceleration_limit },
    { head: 'Jerk', term: 'jerk', number: true, cell: (j) => bound(j.jerk_limit, perSecond(j.position_unit, 3)), sort: (j) => j.jerk_limit }, { head: 'Torque', number: true, cell: (j) => bound(j.effort_limit, unit(j.effort_unit)), sort: (j) => j.effort_limit },
    { head: 'Prior mass (kg)', number: true, cell: (j) => (j.prior ? number(j.prior.mass) : '–'), sort: (j) => j.prior?.mass, term: 'prior' },
  ], drawn.joints, { caption: 'A dash: not limited, or not known' }));
}

function baseTable(base) {
  return [h('p', { class: 'soft' }, `${base.count} combinations of ${base.standard_parameters.length} `, term('standard_parameters', 'standard parameters'), ': all that joint torques can identify of this arm. R in a name means that other parameters are grouped into it.'), table([
    { head: 'Name', term: 'base_parameters', cell: (p) => nameOf(p.name), sort: (p) => p.name }, { head: 'Expression', term: 'standard_parameters', cell: (p) => typeset(p.expression, p.name) }, { head: 'Unit', cell: (p) => unit(p.unit), sort: (p) => p.unit },
  ], base.base_parameters, { caption: 'Base parameters by name' })];
}

/** Runs of this robot, oldest first; of each its result. */
async function runs(robot, kind) {
  const { jobs } = await getJson('/jobs');
  const wanted = jobs.filter((j) => j.kind === kind && [robot.id, robot.name].includes(j.robot) && ['finished', 'cancelled'].includes(j.state)).slice(0, 20).reverse();
  const results = await Promise.all(wanted.map((j) => summaryOf(j).catch(() => null)));
  return wanted.map((job, i) => ({ job, result: results[i] })).filter((r) => r.result?.robot === robot.name);
}

async function showHistory(place, robot) {
  const [designs, identified] = await Promise.all([runs(robot, 'excitation'), runs(robot, 'identification')]);
  fill(place, identified.length ? across(identified) : h('p', { class: 'soft' }, 'No identifications yet.'), designs.length ? table([
    { head: 'Design', cell: (r) => h('a', { href: `/design?id=${r.job.id}` }, time(r.job.finished_at)), sort: (r) => r.job.finished_at }, { head: 'Condition number', term: 'condition_number', number: true, cell: (r) => number(r.result.condition_number), sort: (r) => r.result.condition_number },
    { head: 'Period', term: 'period', number: true, cell: (r) => `${number(r.result.period_s)} s`, sort: (r) => r.result.period_s }, { head: 'Limits', term: 'limits_form', cell: (r) => r.result.request.constraints?.form ?? 'paper' }, { head: 'Ended', term: 'search_end', cell: (r) => searchEnd(r.result.status) },
  ], designs, { caption: 'Designs' }) : null);
}

function across(identified) {
  const all = identified.at(-1).result.base_parameters;
  const name = h('select', { class: 'narrow', id: 'history-parameter' }, all.map((p) => h('option', { value: p.name }, p.name)));
  const chart = h('div', { class: 'plot flat', 'data-label': 'A base parameter in every identification, with two standard deviations either side' });
  const make = () => {
    const points = identified.map((r) => ({ run: r, p: r.result.base_parameters.find((p) => p.name === name.value) })).filter((x) => x.p?.value !== null && x.p);
    return {
      traces: [{ type: 'scatter', mode: 'markers', x: points.map((_, i) => i), y: points.map((x) => x.p.value), error_y: { type: 'data', array: points.map((x) => 2 * x.p.std_dev), color: colour(1), thickness: 2, width: 6 }, marker: { size: 9, color: colour(0) }, hovertemplate: points.map((x) => `${time(x.run.job.finished_at)}: ${measured(x.p.value, x.p.std_dev)}<extra></extra>`) }],
      layout: { height: 260, hovermode: 'closest', xaxis: { title: 'identification', tickvals: points.map((_, i) => i), ticktext: points.map((x) => time(x.run.job.finished_at)), range: [-0.5, points.length - 0.5] }, yaxis: { title: `${name.value} ± 2σ (${unit(all.find((p) => p.name === name.value)?.unit)})` } },
    };
  };
  name.addEventListener('change', () => plot(chart, make));
  plotLater(chart, make);
  return h('div', {}, h('h3', {}, 'A parameter across identifications'), h('label', { class: 'inline' }, 'Parameter', name), chart, table([
    { head: 'Identification', cell: (r) => h('a', { href: `/identification?id=${r.job.id}` }, time(r.job.finished_at)), sort: (r) => r.job.finished_at }, { head: 'Data', term: 'quality', cell: (r) => words(r.result.quality.verdict), sort: (r) => r.result.quality.verdict },
    { head: 'Logs', cell: (r) => r.result.log_report.map((l) => l.file).join(', ') }, { head: 'Residual', term: 'verdict', cell: (r) => (r.result.residual ? h('a', { href: `/loop?id=${r.job.id}` }, words(r.result.residual.verdict)) : '–') },
  ], identified, { caption: 'Identifications' }));
}

async function begin() {
  const { robots } = await getJson('/robots');
  const query = new URLSearchParams(location.search);
  const adding = query.has('new');
  const asked = query.get('robot') ?? query.get('id') ?? robots[0]?.id;
  const which = find('#which');
  fill(which, adding ? h('option', { value: '', selected: true }, 'a new one') : null, robots.map((r) => h('option', { value: r.id, selected: !adding && r.id === asked }, r.name)));
  which.addEventListener('change', () => { location.href = address(which.value); });
  find('#add').hidden = adding;
  if (adding) return addRobot();
  const robot = robots.find((r) => r.id === asked);
  if (!robot) throw Object.assign(new Error(), { problem: { detail: `There is no robot ${asked}.`, hint: 'Add it with the button above.' } });
  return show(robot);
}

begin().catch((e) => explain(find('#trouble'), e));
