// What a recording of a designed trajectory would reveal, effect by effect, and which effects it would not separate.
import { effectName } from './finding.js';
import { h, number, table, term, unit, words } from './dom.js';

const HIDDEN = {
  absorbed: 'absorbed by the base parameters',
  no_torque: 'changes no torque on this motion',
  beyond_range: 'only beyond the sizes that robots have',
  shown_once: 'one part of the motion alone shows it',
  no_values: 'needs prior parameters of the robot',
  against_model: 'visible only against an existing model',
  between_periods: 'needs three periods',
};

const NOISE = {
  request: 'from the request',
  model: 'from the data of the model',
  effort_limits: 'a thousandth of the effort limits, because none was given',
  unit: 'one unit, because none was given and the robot has no effort limits: sizes are in units of the noise',
};

const place = (joints) => joints.join(', ') || 'whole robot';
const physical = (u) => (u === '1' ? '' : ` ${unit(u)}`);
const size = (value, u) => `${number(value, 3)}${physical(u)}`;
const others = (e) => e.assumed.map((a) => `${words(a.name).toLowerCase()} ${size(a.value, a.unit)}`).join(', ');

/** The card, with both tables folded. */
export function detectable(result) {
  const d = result.detectable;
  if (!d) return null;
  const seen = d.effects.filter((e) => e.size !== null);
  const percent = `${number(100 * d.power, 2)} %`;
  return h('section', { class: 'card', id: 'detectable', 'aria-labelledby': 'detectable-title' }, h('h2', { id: 'detectable-title' }, term('detectable', 'Detectable effects')),
    h('p', {}, `Recorded for ${number(d.periods)} periods, a log of this motion is predicted to reveal each effect below in ${percent} of cases from the stated size on, with no more than one false finding in ${number(1 / d.false_alarm)} logs. On simulated logs effects of these sizes were found in 77 to 100 % of cases, 88 % on average.`),
    h('p', { class: 'soft' }, `Torque noise: ${d.torque_noise.map((n) => number(n, 3)).join(', ')} N·m (N for prismatic joints), ${NOISE[d.noise_source]}. Sizes grow in proportion to it, and fall with the root of the number of periods.`),
    h('details', {}, h('summary', {}, `Smallest detectable sizes (${seen.length} of ${d.effects.length} effects are detectable)`), sizes(d)),
    d.pairs.length ? h('details', {}, h('summary', {}, `Not separated at these sizes (${d.pairs.length})`), h('p', { class: 'soft' }, ['Either is reported, with the other as its ', term('rival', 'rival'), '. From the size in the last column on, the log excludes the rival.']), pairs(d)) : null);
}

function sizes(d) {
  return table([
    { head: 'Effect', term: 'effect', cell: (e) => effectName(e), sort: (e) => e.effect },
    { head: 'On', cell: (e) => place(e.joints), sort: (e) => place(e.joints) },
    { head: 'Smallest size', term: 'detectable', number: true, cell: (e) => (e.size === null ? h('span', { class: 'soft' }, HIDDEN[e.hidden] ?? e.hidden) : `${words(e.parameter).toLowerCase()} ${size(e.size, e.unit)}`), sort: (e) => e.size },
    { head: 'With', cell: (e) => h('span', { class: 'soft' }, e.size === null ? '' : others(e)) },
  ], d.effects, { caption: 'Smallest detectable size of every effect' });
}

function pairs(d) {
  return table([
    { head: 'Effect', term: 'effect', cell: (p) => words(p.effect), sort: (p) => p.effect },
    { head: 'On', cell: (p) => place(p.joints), sort: (p) => place(p.joints) },
    { head: 'Confused with', term: 'rival', cell: (p) => `${words(p.rival)} on ${place(p.rival_joints)}`, sort: (p) => p.rival },
    { head: 'Correlation', term: 'correlation', number: true, cell: (p) => number(p.correlation, 3), sort: (p) => p.correlation },
    { head: 'Separated from', term: 'detectable', number: true, cell: (p) => (p.told_apart_from === null ? 'no size' : `${words(p.parameter).toLowerCase()} ${size(p.told_apart_from, p.unit)}`), sort: (p) => p.told_apart_from },
  ], d.pairs, { caption: 'Effects that are not separated' });
}
