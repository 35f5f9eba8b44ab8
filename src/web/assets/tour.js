// The demo: one click from the start page to a closed loop, and what there is to see on the way.
import { explain, follow, send } from './api.js';
import { fill, find, h } from './dom.js';

const LOGS = [['log', 'run.csv.gz'], ['validation', 'check.csv.gz']];
const NAME = 'Demo: iiwa 14 with a hidden spring';

/** What each page of the tour shows, and where it goes on. */
const STEPS = [
  { title: 'The finding', text: 'A virtual KUKA iiwa 14 has run a designed motion. Its joint A4 has a spring that the model does not declare. The log alone led to it: see its stiffness, the error before and after on a second log, and which other causes are excluded.',
    next: (id) => `/identification?id=${id}`, words: 'See the model' },
  { title: 'The model', text: 'The same log gives the parameters with their standard deviations, bodies that are physically possible, and errors per joint on the second log. Download the model as URDF, or read the report.',
    next: () => '/design?robot=iiwa14', words: 'See where such a motion comes from' },
  { title: 'The motion', text: 'This form designs the motion that makes the parameters visible, within the limits of the robot and its cell. Start the search to watch it, and download the trajectory for the controller.',
    next: () => '/robot?new=1', words: 'Add your own robot' },
  { title: 'Your robot', text: 'Describe your robot by a URDF file or a DH table. Then design a motion, run it, and drop the log on the page “Identification”.', next: () => '/', words: 'End the tour' },
];

/** The card on the start page. */
export function invitation(place, empty) {
  const trouble = h('div');
  const status = h('p', { class: 'soft', role: 'status' });
  const go = h('button', { type: 'button', class: empty ? 'primary' : '', id: 'demo', onclick: () => run(go, status).catch((e) => { go.disabled = false; fill(status); explain(trouble, e); }) }, 'Run the demo');
  fill(place, h('section', { class: 'card', 'aria-labelledby': 'demo-title' }, h('div', { class: 'row spread' }, h('h2', { id: 'demo-title' }, empty ? 'New here? See the whole loop in a minute' : 'Demo'), go),
    h('p', {}, 'A virtual robot with a hidden effect: its log is identified, and the page shows what the model lacks.'), status, trouble));
}

async function run(button, status) {
  button.disabled = true;
  fill(status, 'Loading the log of the virtual robot …');
  const form = new FormData();
  form.append('request', JSON.stringify({ robot: 'iiwa14', estimator: 'wls', trace: true, feasible: { method: 'consistent' }, prediction_points: 2000 }));
  for (const [kind, name] of LOGS) form.append(kind, await (await send(`/assets/demo/${name}`)).blob(), `demo-${name}`);
  fill(status, 'Identifying …');
  const job = await (await send('/identify', { method: 'POST', body: form })).json();
  // Servers for others may not let everybody name a run.
  await send(`/jobs/${job.id}`, { method: 'PATCH', headers: { 'content-type': 'application/json' }, body: JSON.stringify({ name: NAME }) }).catch(() => {});
  const ended = await follow(job.id, (now) => now.step && fill(status, `${now.step.what} …`));
  if (ended.error) throw Object.assign(new Error(ended.error.detail), { problem: ended.error });
  location.href = `/loop?id=${job.id}&tour=1&of=${job.id}`;
}

/** The banner of a page of the tour. */
export function guide(query) {
  const at = Number(query.get('tour'));
  const step = STEPS[at - 1];
  if (!step) return;
  const of = query.get('of');
  const next = step.next(encodeURIComponent(of ?? ''));
  const address = at < STEPS.length ? `${next}${next.includes('?') ? '&' : '?'}tour=${at + 1}${of ? `&of=${encodeURIComponent(of)}` : ''}` : next;
  find('#main').prepend(h('aside', { class: 'notice good', id: 'tour', 'aria-label': 'Tour' }, h('p', {}, h('strong', {}, `Tour ${at} of ${STEPS.length}: ${step.title}. `), step.text), h('p', {}, h('a', { class: 'button', href: address }, step.words))));
}
