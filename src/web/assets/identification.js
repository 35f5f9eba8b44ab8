// Identification: logs in, what was understood of them, the result.
import { moveTo } from './address.js';
import { Refused, explain, follow, getJson, send } from './api.js';
import { reached } from './criteria.js';
import { fill, find, h, number, time } from './dom.js';
import { markError, unmark } from './field-errors.js';
import { numeric, value } from './form-values.js';
import { JsonFiles, trajectoryOf } from './json-files.js';
import { LogColumns } from './log-columns.js';
import { readHead } from './log-file.js';
import { inShort, showPreview } from './log-preview.js';
import { sayWhatJoins, showStep } from './identification-steps.js';
import { showIdentification, showValidation } from './identify-result.js';
import { OwnEffects } from './own-effects.js';
import { plotly } from './plot.js';
import { feasible, preprocess, showMethod } from './preparation-form.js';


/** Points of every plotted series: more than any screen shows, thinned by the server with all peaks kept. */
const POINTS = 6000;
const files = { log: [], validation: [] };
let robots = [];
const columns = new LogColumns(find('#columns-place'), () => previewSoon());
const own = new OwnEffects({ place: find('#own-effects-list'), add: find('#own-effects-add'), choose: find('#own-effects-choose'), joints: () => robots.find((r) => r.id === value('robot'))?.joints ?? [] });
const executed = new JsonFiles(find('#excitation-file'), trajectoryOf, () => previewSoon());
const ROBOT = 'dynident.robot';

function request() {
  return {
    robot: value('robot'), excitation: (executed.list[0] ?? value('excitation')) || undefined, period_s: numeric(value('period')), columns: columns.value(),
    preprocess: preprocess(), estimator: value('estimator'),
    offset: find('#offset').checked || undefined, trace: find('#trace').checked, feasible: feasible(), prediction_points: POINTS, effects: own.value(),
  };
}

function body(asked) {
  const form = new FormData();
  form.append('request', JSON.stringify(asked));
  for (const kind of ['log', 'validation']) files[kind].forEach((f) => form.append(kind, f, f.name));
  return form;
}

/** Counts what the user has begun: a file that was still being read does not put its preview in the place of a result. */
let turn = 0;
async function take(kind, list) {
  turn += 1;
  const mine = turn;
  files[kind] = [...list];
  const size = (bytes) => (bytes > 1e6 ? `${number(bytes / 1e6, 3)} MB` : `${Math.ceil(bytes / 1e3)} kB`);
  fill(find(`#${kind}-names`), files[kind].map((f) => h('li', {}, `${f.name} (${size(f.size)})`)));
  unmark(find('#work'));
  ['#trouble', '#form-trouble'].forEach((place) => fill(find(place)));
  if (await showColumns() && mine === turn) await preview();
}

/** On a narrow screen: the result before the form, or the form before what it previews. */
function arrange(shown) {
  ['with-result', 'with-preview'].forEach((name) => find('#work').classList.toggle(name, name === shown));
  if (shown === 'with-result') sayState();
}

/** Beside the button: what is known of the logs, and the way there. */
function sayState(text, part) {
  fill(find('#go-state'), text ? h('a', { href: part }, text) : null);
}

/** The columns of the first log; all logs of one request have the same. Hands back whether they can be read. */
async function showColumns() {
  const first = files.log[0] ?? files.validation[0];
  const robot = robots.find((r) => r.id === value('robot'));
  if (!first || !robot) return Boolean(first);
  arrange('with-preview');
  const mine = turn;
  try {
    const head = await readHead(first);
    if (mine !== turn) return false;
    columns.show(head, robot, { files: files.log.slice(1).map((f) => f.name) });
    return true;
  } catch (error) {
    columns.clear();
    looking?.abort();
    fill(find('#result'));
    sayState('The log cannot be read', '#trouble');
    explain(find('#trouble'), error);
    atLog(error);
    return false;
  }
}

/** What is wrong with a log as a whole is said at its field as well. */
function atLog({ problem }) {
  if (!problem || problem.errors?.length) return;
  const kind = files.validation.some((f) => problem.detail?.includes(f.name)) && !files.log.some((f) => problem.detail?.includes(f.name)) ? 'validation' : 'log';
  markError(find('#form'), { pointer: `/${kind}`, detail: problem.detail?.replace(/^log (`[^`]*`): /, '$1: '), hint: problem.hint });
}

let looking = null;
/** Asks what is understood of the logs; anew whenever the form changes. */
async function preview() {
  if (!files.log.length && !files.validation.length) return;
  looking?.abort();
  if (columns.head && columns.missing().length) {
    fill(find('#result'));
    sayState('Assign the columns', '#columns-place');
    return;
  }
  looking = new AbortController();
  const { signal } = looking;
  unmark(find('#work'));
  fill(find('#form-trouble'));
  arrange('with-preview');
  sayState('Reading the logs …', '#result');
  fill(find('#result'), h('section', { class: 'card' }, h('p', { class: 'soft' }, 'Reading the logs …'), h('progress')));
  try {
    // What is read of the logs does not depend on effects, which may be half written.
    const seen = await (await send('/identify/preview', { method: 'POST', body: body({ ...request(), effects: undefined }), signal })).json();
    await showPreview(find('#result'), seen);
    sayState(inShort(seen), '#result');
  } catch (error) {
    if (signal.aborted) return;
    fill(find('#result'));
    sayState('The logs cannot be used', '#trouble');
    explain(find('#trouble'), error, find('#work'));
    atLog(error);
    return;
  }
  fill(find('#trouble'));
}

let waiting = null;
function previewSoon() {
  clearTimeout(waiting);
  waiting = setTimeout(preview, 600);
}

async function watch(id) {
  const live = find('#live');
  arrange('with-result');
  fill(find('#trouble'));
  try {
    // Most often the job has ended, and its result is megabytes: it is on its way while the state is asked for.
    let [job, answer] = await Promise.all([getJson(`/jobs/${id}`), send(`/identify/${id}`).catch(() => null)]);
    if (['queued', 'running'].includes(job.state)) {
      answer = null;
      fill(find('#result'));
      live.hidden = false;
      live.scrollIntoView({ block: 'center' });
      await follow(id, (now) => showStep(live, now));
    }
    live.hidden = true;
    if (answer?.status !== 200) answer = await send(`/identify/${id}`);
    performance.mark('answered');
    await showIdentification(find('#result'), await answer.json());
    if (scrollY > 0) find('#result').scrollIntoView({ block: 'start' });
  } catch (error) {
    live.hidden = true;
    explain(find('#trouble'), error);
    sayState('The identification failed', '#trouble');
    if (error.problem?.code === 'invalid_log') atLog(error);
  }
}

/** The identification whose model was checked, where this browser asked for the check. */
const modelOf = async (id) => {
  const from = sessionStorage.getItem(`dynident.checked.${id}`);
  return from ? getJson(`/identify/${from}?predictions=false`).catch(() => null) : null;
};

async function validation(id) {
  arrange('with-result');
  const job = await getJson(`/jobs/${id}`);
  if (['queued', 'running'].includes(job.state)) await follow(id, (now) => showStep(find('#live'), now));
  find('#live').hidden = true;
  showValidation(find('#result'), await getJson(`/validate/${id}`), await modelOf(id));
}

async function prepare(query) {
  const [known, { jobs }] = await Promise.all([getJson('/robots'), getJson('/jobs')]);
  robots = known.robots;
  // After a run: that of the run; else the last one that was used here.
  const of = jobs.find((j) => j.id === (query.get('id') ?? query.get('validation')))?.robot;
  const wanted = [query.get('robot'), of, localStorage.getItem(ROBOT), 'iiwa14'];
  const chosen = wanted.find((id) => robots.some((r) => r.id === id));
  fill(find('#robot'), robots.map((r) => h('option', { value: r.id, selected: r.id === chosen }, `${r.name} (${r.joints.length} joints)`)));
  const designs = jobs.filter((j) => j.kind === 'excitation' && ['finished', 'cancelled'].includes(j.state) && j.outcome !== 'Infeasible');
  find('#excitation').append(...designs.map((j) => h('option', { value: j.id, selected: j.id === query.get('excitation') }, [time(j.finished_at), reached(j.progress)].filter(Boolean).join(', '))));
}

/** Effects and columns are of the joints of another robot; hands back whether the logs can be read. */
async function changeRobot() {
  localStorage.setItem(ROBOT, value('robot'));
  own.draw();
  return !(files.log.length || files.validation.length) || showColumns();
}

for (const kind of ['log', 'validation']) {
  const zone = find(`[data-drop=${kind}]`);
  find(`#${kind}`).addEventListener('change', (e) => take(kind, e.target.files));
  zone.addEventListener('dragover', (e) => { e.preventDefault(); zone.classList.add('over'); });
  zone.addEventListener('dragleave', () => zone.classList.remove('over'));
  zone.addEventListener('drop', (e) => { e.preventDefault(); zone.classList.remove('over'); take(kind, e.dataTransfer.files); });
}
find('#form').addEventListener('change', async (e) => {
  if (e.target.type === 'file' || e.target.closest('#own-effects')) return;
  if (e.target.id === 'robot' && !await changeRobot()) return;
  previewSoon();
});
find('#form').addEventListener('submit', async (event) => {
  event.preventDefault();
  turn += 1;
  clearTimeout(waiting);
  looking?.abort();
  unmark(find('#work'));
  ['#form-trouble', '#trouble'].forEach((place) => fill(find(place)));
  sayState();
  const go = find('#go');
  go.disabled = true;
  try {
    if (!files.log.length) throw new Refused({ detail: 'There is no log to identify from.', errors: [{ pointer: '/log', detail: 'is missing', hint: 'choose a file above, or drop it there' }] });
    if (columns.head && columns.missing().length) throw new Refused({ detail: `The columns are not complete: ${columns.missing().join('; ')}.`, hint: 'Choose them in the table of columns.' });
    localStorage.setItem(ROBOT, value('robot'));
    const job = await (await send('/identify', { method: 'POST', body: body(request()) })).json();
    moveTo(`/identification?id=${job.id}`);
    columns.clear();
    await watch(job.id);
  } catch (error) {
    explain(find('#form-trouble'), error, find('#work'));
  } finally {
    go.disabled = false;
  }
});

const query = new URLSearchParams(location.search);
if (query.get('id')) plotly();

own.look();
showMethod();
['feasible', 'feasible-method'].forEach((id) => find(`#${id}`).addEventListener('change', showMethod));
prepare(query)
  .then(() => query.get('after') && sayWhatJoins(query.get('after')))
  .catch((e) => explain(find('#trouble'), e));
// The form is filled in meanwhile.
if (query.get('id')) watch(query.get('id'));
else if (query.get('validation')) validation(query.get('validation')).catch((e) => explain(find('#trouble'), e));
