// A trajectory for the controller: a slow first run, then as designed, in the format that the controller reads.
import { download } from './api.js';
import { fill, h, labelled, number, term } from './dom.js';

/** Format of the interface: what reads it, ending of the file, and for robots of how many joints. */
const FORMATS = {
  csv: ['Table (CSV): time, q, qd, qdd', 'csv'], json: ['The same table (JSON)', 'json'], yaml: ['ROS 2 action goal, FollowJointTrajectory (YAML)', 'yaml'],
  joint_trajectory: ['ROS 2 message, JointTrajectory (JSON)', 'json'], mcap: ['ROS 2 bag (MCAP)', 'mcap'], urscript: ['Universal Robots program (URScript)', 'script', 6], npz: ['NumPy arrays (npz)', 'npz'],
};
const KEPT = 'dynident.trajectory-format';
/** A first run moves this share of the amplitude (%) this many times slower: a thirteenth of the speeds, a fiftieth of the accelerations. */
const FIRST = { share: 30, slow: 4 };

export function downloads(result) {
  const field = (id, label, value, least, options = {}) => h('label', { class: 'stacked' }, label, h('input', { type: 'number', id: `download-${id}`, value, min: least, step: 'any', ...options }));
  const entries = Object.entries(FORMATS).filter(([, [, , joints]]) => !joints || joints === result.joints.length);
  const format = h('select', { id: 'download-format' }, entries.map(([key, [name]]) => h('option', { value: key, selected: key === localStorage.getItem(KEPT) }, name)));
  const further = result.further ?? [];
  const which = further.length ? h('select', { id: 'download-which' }, [result, ...further].map((_, i) => h('option', { value: i }, `trajectory ${i + 1}`))) : null;
  const whole = h('div', { class: 'three' }, h('div', { class: 'stacked' }, labelled('Format', 'download-format', 'trajectory_format'), format), field('rate', 'Sample rate (Hz)', 1000, 1), field('periods', 'Periods', Math.max(result.request.periods ?? 1, 1), 1, { step: 1 }), which ? h('label', { class: 'stacked' }, 'Trajectory', which) : null);
  const first = h('div', { class: 'three' }, field('share', 'First run: share of the amplitude (%)', FIRST.share, 1, { max: 100 }), field('slow', 'First run: times slower', FIRST.slow, 1, { max: 100 }));
  const way = h('div', { class: 'three' }, field('in', 'Run-in (s)', '', 0, { placeholder: 'none', max: 120 }), field('out', 'Run-out (s)', '', 0, { placeholder: 'none', max: 120 }),
    h('label', { class: 'stacked' }, 'Pose before and after (rad or m)', h('input', { id: 'download-from', placeholder: 'where the motion begins' })));
  const links = h('div', { class: 'actions' });
  const element = h('div', { id: 'downloads' }, h('h3', {}, 'Download for the controller'), whole,
    h('details', {}, h('summary', {}, 'First run, run-in and run-out'), first, way, h('p', { class: 'help' }, 'A ', term('run_in', 'run-in'), ' is a way from a pose at rest into the motion, within the limits of the design; with a pose and no duration, a duration is chosen.')),
    links, h('p', { class: 'help' }, 'Run the slow one first and watch it. Then run the motion as designed, several periods in a row: their repetition measures the noise.'), h('p', {}, identifyLink(result)));
  const entered = (id) => element.querySelector(`#download-${id}`).value.trim();
  const link = (label, slow) => {
    const query = new URLSearchParams({ rate_hz: entered('rate'), periods: slow ? 1 : entered('periods') });
    if (slow && Number(entered('share')) < 100) query.set('backoff', entered('share') / 100);
    if (slow && Number(entered('slow')) > 1) query.set('slow', entered('slow'));
    if (which?.value > 0) query.set('index', which.value);
    for (const [id, name] of [['in', 'run_in_s'], ['out', 'run_out_s'], ['from', 'from']]) if (entered(id)) query.set(name, entered(id).replaceAll('−', '-').split(/[\s,;]+/).join(','));
    const suffix = `${which?.value > 0 ? `-${Number(which.value) + 1}` : ''}${slow ? '-first-run' : ''}`;
    return download(label, `/excitation/${result.id}/trajectory?format=${format.value}&${query}`, `trajectory-${result.id}${suffix}.${FORMATS[format.value][1]}`);
  };
  const build = () => {
    localStorage.setItem(KEPT, format.value);
    fill(links, link(`1. Slow first run: ${number(Number(entered('share')), 3)} %, ${number(Number(entered('slow')), 3)} × slower`, true), link('2. As designed', false), download('Result with request (JSON)', `/excitation/${result.id}`, `design-${result.id}.json`));
  };
  element.addEventListener('input', build);
  build();
  return element;
}

/** The identification whose data this design adds to. */
export const earlier = (result) => result.request.model?.identification ?? (result.request.given ?? []).map((g) => g.identification).find(Boolean);

export function identifyLink(result, primary = false) {
  const query = new URLSearchParams({ excitation: result.id });
  if (typeof result.request.robot === 'string') query.set('robot', result.request.robot);
  if (earlier(result)) query.set('after', earlier(result));
  return h('a', { class: primary ? 'button primary' : 'button', href: `/identification?${query}` }, 'I have run it: identify');
}

