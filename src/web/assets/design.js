// Design: the form, the search as it goes, the result.
import { explain, follow, getJson, postJson, send, unmark } from './api.js';
import { fill, find, h } from './dom.js';
import { Live } from './design-live.js';
import { showDesign } from './design-result.js';

const CRITERIA = {
  condition_number: 'Ratio of the best to the worst determined direction. The usual choice, and the one of the published results.',
  scaled_condition_number: 'The same with every column of the regressor at length one: does not depend on units.',
  i_optimality: 'Expected error of predicted torques over the whole workspace. Choose it when the model will be used for control.',
  d_optimality: 'Geometric mean of all deviations. Does not depend on units, and lets single parameters stay poor.',
  a_optimality: 'Mean variance of the parameters. Weighs large parameters most.',
};
const value = (id) => find(`#${id}`).value.trim();
const list = (text) => (text ? text.split(/[\s,;]+/).filter(Boolean).map((t) => (Number.isFinite(Number(t)) ? Number(t) : t)) : undefined);
const numeric = (text) => (text === '' ? undefined : Number.isFinite(Number(text)) ? Number(text) : text);

/** The document that the form stands for. What is left empty is left out: the interface has the defaults. */
function request() {
  const period = numeric(value('period'));
  return {
    robot: value('robot'),
    fourier: { order: numeric(value('order')), fundamental_hz: typeof period === 'number' ? 1 / period : period },
    sample_rate_hz: numeric(value('rate')),
    criterion: value('criterion'),
    constraints: { form: value('form-of-limits'), start: value('start'), start_position: list(value('start-position')) },
    torque_noise: list(value('noise')),
    search: { seed: numeric(value('seed')), time_limit_s: numeric(value('time-limit')) },
  };
}

function explainForm() {
  const [period, order] = [Number(value('period')), Number(value('order'))];
  find('#criterion-help').textContent = CRITERIA[value('criterion')];
  find('#period-help').textContent = period > 0 && order > 0
    ? `Fastest harmonic ${Number((order / period).toPrecision(3))} Hz. Longer periods are slower and smoother; more harmonics reach lower numbers. Five in ten seconds suit seven joints.` : '';
  find('#as-request').textContent = JSON.stringify(request(), null, 1);
}

async function fillRobots(chosen) {
  const { robots } = await getJson('/robots');
  fill(find('#robot'), robots.map((r) => h('option', { value: r.id, selected: r.id === chosen }, `${r.name} (${r.joints.length} joints)`)));
  explainForm();
}

/** Puts an earlier request into the form; a robot that stood in the request itself is offered under its own name. */
function refill(document) {
  const set = (id, v) => { if (v !== undefined && v !== null) find(`#${id}`).value = Array.isArray(v) ? v.join(', ') : v; };
  if (typeof document.robot === 'string') set('robot', document.robot);
  if (document.fourier?.fundamental_hz) set('period', Number((1 / document.fourier.fundamental_hz).toPrecision(10)));
  set('order', document.fourier?.order);
  set('rate', document.sample_rate_hz);
  set('criterion', document.criterion);
  set('form-of-limits', document.constraints?.form ?? 'paper');
  set('start', document.constraints?.start);
  set('start-position', document.constraints?.start_position);
  set('noise', document.torque_noise);
  set('seed', document.search?.seed);
  set('time-limit', document.search?.time_limit_s);
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
      live.begin(job);
      live.show(job);
      find('#live').scrollIntoView({ block: 'start' });
      await follow(id, (now) => live.show(now), signal);
    }
    const result = await getJson(`/excitation/${id}`);
    live.end();
    refill(result.request);
    await showDesign(find('#result'), result);
    if (scrollY > 0) find('#result').scrollIntoView({ block: 'start' });
  } catch (error) {
    live.end();
    explain(find('#trouble'), error);
  }
}

find('#form').addEventListener('input', explainForm);
find('#form').addEventListener('submit', async (event) => {
  event.preventDefault();
  unmark(event.target);
  fill(find('#form-trouble'));
  const go = find('#go');
  go.disabled = true;
  try {
    const job = await postJson('/excitation', request());
    history.pushState(null, '', `/design?id=${job.id}`);
    watch(job.id);
  } catch (error) {
    explain(find('#form-trouble'), error, event.target);
  } finally {
    go.disabled = false;
  }
});
addEventListener('popstate', () => location.reload());

const query = new URLSearchParams(location.search);
fillRobots(query.get('robot') ?? 'iiwa14')
  .then(() => query.get('id') && watch(query.get('id')))
  .catch((e) => explain(find('#trouble'), e));
