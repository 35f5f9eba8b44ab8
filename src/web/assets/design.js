// Design: the form, the search as it goes, the result.
import { explain, follow, getJson, postJson, send } from './api.js';
import { moveTo } from './address.js';
import { CellView } from './cell-view.js';
import { CRITERIA } from './criteria.js';
import { askedFor } from './decide.js';
import { fill, find, h, number } from './dom.js';
import { unmark, unmarkAround } from './field-errors.js';
import { harmonics, list, numeric, some, value } from './form-values.js';
import { Live } from './design-live.js';
import { showDesign } from './design-result.js';
import { sayWhatIsInTheWay } from './in-the-way.js';
import { Known } from './known-form.js';
import { Obstacles } from './obstacles.js';
import { OwnEffects } from './own-effects.js';
import { plotly } from './plot.js';
import { TouchingPairs } from './touching-pairs.js';

const known = new Known(() => explainForm());
const obstacles = new Obstacles(find('#obstacles'), () => explainForm());
const cell = new CellView();
const touching = new TouchingPairs(find('#touching'), () => explainForm());
let robots = [];
const joints = () => robots.find((r) => r.id === value('robot'))?.joints ?? [];
const own = new OwnEffects({ place: find('#own-effects-list'), add: find('#own-effects-add'), choose: find('#own-effects-choose'), joints, changed: () => explainForm() });
const query = new URLSearchParams(location.search);

const shortened = (numbers) => numbers.join(', ');

function space() {
  const placed = obstacles.value();
  const self = find('#self-collision').checked ? { ignore: touching.value() } : undefined;
  return some({ ...placed, self_collision: self }) && { clearance: numeric(value('clearance')), ...placed, self_collision: self };
}

/** The document that the form stands for. What is left empty is left out: the interface has the defaults. */
function request() {
  const period = numeric(value('period'));
  const torque = find('#torque-on').checked ? { limits: list(value('torque-limits')), safety_factor: numeric(value('torque-safety')) } : undefined;
  return {
    robot: value('robot'),
    fourier: { order: numeric(value('order')), fundamental_hz: list(value('frequencies')) ?? (typeof period === 'number' && period !== 0 ? 1 / period : period), harmonics: harmonics(value('harmonics')) },
    sample_rate_hz: numeric(value('rate')),
    criterion: value('criterion'),
    constraints: { form: value('form-of-limits'), start: value('start'), start_position: list(value('start-position')), torque, space: space() },
    torque_noise: list(value('noise')),
    ...known.value(value('criterion')),
    effects: own.value(),
    periods: numeric(value('periods')), trajectories: numeric(value('trajectories')), backoff: numeric(value('backoff')),
    search: { seed: numeric(value('seed')), time_limit_s: numeric(value('time-limit')), starts: numeric(value('search-starts')), max_evaluations: numeric(value('search-evaluations')), jobs_per_round: numeric(value('jobs-per-round')) },
  };
}

/** What closed parts of the form hold, beside their names. */
function sayWhatIsSet(asked) {
  const s = asked.constraints.space;
  const placed = [...(s?.half_spaces ?? []), ...(s?.boxes ?? [])].map((o) => o.name);
  const states = {
    torque: asked.constraints.torque ? `safety factor ${asked.constraints.torque.safety_factor ?? 1.25}` : '',
    space: s ? [placed.length > 2 ? `${placed.length} obstacles` : placed.join(', '), s.self_collision && 'self-collision'].filter(Boolean).join(', ') : '',
    backoff: asked.backoff ? `${number(100 * asked.backoff, 3)} %` : '',
    known: [asked.warm_start && 'warm start', asked.model && 'model', asked.given && `data of ${asked.given.length} run${asked.given.length > 1 ? 's' : ''}`].filter(Boolean).join(', '),
    effects: asked.effects ? String(asked.effects.length) : '',
    search: [asked.search.starts && `${asked.search.starts} starts`, asked.search.max_evaluations && `${asked.search.max_evaluations} evaluations`].filter(Boolean).join(', '),
  };
  for (const [name, text] of Object.entries(states)) {
    const tag = find(`[data-state=${name}]`);
    tag.textContent = text;
    tag.hidden = !text;
  }
}

function explainForm() {
  const [period, order] = [Number(value('period')), Number(value('order'))];
  const asked = request();
  find('#criterion-help').textContent = CRITERIA[value('criterion')].help;
  find('#period-help').textContent = period > 0 && order > 0
    ? `Fastest harmonic ${Number((order / period).toPrecision(3))} Hz. Longer periods are slower and smoother; more harmonics reach lower numbers. Five harmonics in ten seconds suit seven joints.` : '';
  if (value('criterion') === 'rival_evidence') find('#known-part').open = true;
  sayWhatIsSet(asked);
  showCell(asked);
  find('#as-request').textContent = JSON.stringify(asked, null, 1);
}

/** The arm among what is placed around it, while that part of the form is open. */
function showCell({ robot, constraints: { space: placed, start_position: start } }) {
  const wanted = find('#space-part').open && placed;
  fill(find('#cell'), wanted ? cell.element : null);
  if (wanted) cell.show(robot, placed, start);
}

/**
 * A robot avoids itself and a floor, unless somebody says otherwise. One whose links have no shape of their own does so with
 * capsules along them, which costs a few percent of the criterion, and the page says where to give it a shape.
 */
let selfTouched = false;
let floorTouched = false;
let startTouched = false;
async function avoidSelf(fresh) {
  const robot = value('robot');
  const { shape, shape_guessed: guessed } = await cell.load(robot);
  if (robot !== value('robot')) return;
  const links = new Set(shape.map((capsule) => capsule.joint)).size;
  const box = find('#self-collision');
  if (fresh && !selfTouched) box.checked = links > 1;
  if (fresh && !floorTouched) await placeFloor(links > 0);
  fill(find('#self-help'), links > 1 && !guessed ? null : h('span', {}, 'The description of this robot has no shape: capsules from joint to joint stand in for its links. ', h('a', { href: `/robot?robot=${encodeURIComponent(robot)}` }, 'Edit the robot'), ' and add capsules of the real links where it comes close to anything.'));
  explainForm();
}

/** Counts the floors that are being placed. */
let placing = 0;
/** A floor below the arm, as long as nobody has placed anything, and a start from where a motion is possible. */
async function placeFloor(possible) {
  obstacles.set(null);
  // Another robot may be chosen, or something placed, before the height of the floor is known.
  placing += 1;
  const mine = placing;
  const wanted = () => mine === placing && !floorTouched;
  if (possible) await addObstacle('floor', wanted);
  if (!wanted()) return;
  const { robot, constraints: { start_position: start, space: placed } } = request();
  const [floor] = placed?.half_spaces ?? [];
  const low = floor !== undefined && await cell.startsLow(robot, floor, start).catch(() => false);
  if (startTouched) return;
  find('#start').value = low ? 'free' : 'zero';
  find('#start-low').hidden = !low;
}

async function addObstacle(what, wanted = () => true) {
  const { robot, constraints: { start_position: start } } = request();
  const placed = what === 'floor' ? await cell.floor(robot, numeric(value('clearance')) || 0, start).catch(() => ({})) : {};
  if (wanted()) obstacles.add(what, placed);
}

async function fillRobots(chosen) {
  ({ robots } = await getJson('/robots'));
  fill(find('#robot'), robots.map((r) => h('option', { value: r.id, selected: r.id === chosen }, `${r.name} (${r.joints.length} joints)`)));
  touching.of(joints());
  await known.load(value('robot'));
  explainForm();
  await avoidSelf(!query.get('id'));
}

/** Puts an earlier request into the form; a robot that stood in the request itself is offered under its own name. */
async function refill(document) {
  const set = (id, v) => { find(`#${id}`).value = v === undefined || v === null ? find(`#${id}`).defaultValue ?? '' : Array.isArray(v) ? shortened(v) : v; };
  if (typeof document.robot === 'string') find('#robot').value = document.robot;
  const hz = document.fourier?.fundamental_hz;
  if (typeof hz === 'number') set('period', Number((1 / hz).toPrecision(10)));
  set('frequencies', Array.isArray(hz) ? hz : undefined);
  set('order', document.fourier?.order);
  set('harmonics', document.fourier?.harmonics?.map((joint) => joint.join(', ')).join('; '));
  set('rate', document.sample_rate_hz);
  find('#criterion').value = document.criterion === 'recommended' ? 'i_optimality' : document.criterion ?? 'condition_number';
  const limits = document.constraints ?? {};
  find('#form-of-limits').value = limits.form ?? 'paper';
  find('#start').value = limits.start ?? 'zero';
  set('start-position', limits.start_position);
  find('#torque-on').checked = Boolean(limits.torque);
  set('torque-limits', limits.torque?.limits);
  set('torque-safety', limits.torque?.safety_factor);
  find('#self-collision').checked = Boolean(limits.space?.self_collision);
  set('clearance', limits.space?.clearance);
  obstacles.set(limits.space);
  touching.joints = joints();
  touching.set(limits.space?.self_collision);
  own.set(document.effects);
  for (const [id, key] of [['noise', 'torque_noise'], ['periods', 'periods'], ['trajectories', 'trajectories'], ['backoff', 'backoff']]) set(id, document[key]);
  set('seed', document.search?.seed);
  for (const [id, key] of [['time-limit', 'time_limit_s'], ['search-starts', 'starts'], ['search-evaluations', 'max_evaluations'], ['jobs-per-round', 'jobs_per_round']]) set(id, document.search?.[key]);
  await known.load(value('robot'), document);
  explainForm();
}

let watching = null;

/** Follows a job to its end and shows what came out. */
async function watch(id) {
  watching?.abort();
  watching = new AbortController();
  find('#work').classList.add('with-result');
  const { signal } = watching;
  fill(find('#trouble'));
  const live = new Live(find('#live'), () => send(`/jobs/${id}`, { method: 'DELETE' }).catch((e) => explain(find('#trouble'), e)));
  try {
    const job = await getJson(`/jobs/${id}`);
    if (['queued', 'running'].includes(job.state)) {
      fill(find('#result'));
      const asked = askedFor(id);
      live.begin(job, asked);
      if (asked) await refill(asked);
      live.show(job);
      find('#live').scrollIntoView({ block: 'start' });
      await follow(id, (now) => live.show(now), signal);
    }
    const result = await getJson(`/excitation/${id}`);
    await refill(result.request);
    await showDesign(find('#result'), result);
    live.end();
    if (!result.coefficients && result.reason) sayWhatIsInTheWay(result);
    if (scrollY > 0) find('#result').scrollIntoView({ block: 'start' });
  } catch (error) {
    live.end();
    explain(find('#trouble'), error);
  }
}

find('#form').addEventListener('input', (event) => {
  unmarkAround(event.target);
  explainForm();
});
find('#self-collision').addEventListener('input', () => { selfTouched = true; });
find('#start').addEventListener('input', () => { startTouched = true; find('#start-low').hidden = true; });
/** A pair that comes near without harm, chosen in the table of clearances. */
document.addEventListener('may-touch', ({ detail: pair }) => {
  find('#self-collision').checked = true;
  selfTouched = true;
  find('#space-part').open = true;
  touching.add(pair);
  find('#touching').scrollIntoView({ block: 'center' });
});
/** Pairs and effects are of the joints of another robot. */
find('#robot').addEventListener('change', () => { touching.of(joints()); own.draw(); });
find('#robot').addEventListener('change', () => known.load(value('robot')).then(() => avoidSelf(true)).catch((e) => explain(find('#form-trouble'), e)));
document.querySelectorAll('[data-add]').forEach((button) => button.addEventListener('click', () => { floorTouched = true; addObstacle(button.dataset.add); }));
find('#space-part').addEventListener('toggle', explainForm);
['input', 'click'].forEach((name) => find('#obstacles').addEventListener(name, () => { floorTouched = true; }));
find('#form').addEventListener('submit', async (event) => {
  event.preventDefault();
  unmark(event.target);
  fill(find('#form-trouble'));
  const go = find('#go');
  go.disabled = true;
  try {
    const job = await postJson('/excitation', request());
    moveTo(`/design?id=${job.id}`);
    watch(job.id);
  } catch (error) {
    explain(find('#form-trouble'), error, event.target);
  } finally {
    go.disabled = false;
  }
});

if (query.get('id')) plotly();
own.look();

fillRobots(query.get('robot') ?? 'iiwa14')
  .then(() => query.get('id') && watch(query.get('id')))
  .catch((e) => explain(find('#trouble'), e));
