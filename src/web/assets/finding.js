// Parts of a finding that several pages show.
import { formula } from './expression.js';
import { figure, h, measured, number, said, sentence, table, term, unit, words } from './dom.js';

/** Whether a finding or effect has a formula of a user's own. */
const isOwn = ({ effect, law }) => Boolean(law) && !isLaw(effect);

/** Whether an effect is a law that was found: in positions and speeds, or in a further quantity. */
const isLaw = (effect) => effect === 'law' || effect.startsWith('law_');

/** The name of an effect of `{effect, law}`, with help. */
export const effectName = (of) => (isOwn(of) ? term('own_effect', of.effect) : isLaw(of.effect) ? term('effect_law', 'Law') : term(`effect_${of.effect}`, words(of.effect)));

/** The name of a fault of a log, with help. */
export const faultName = (code) => term(`fault_${code}`, words(code));

/** Constants of laws as their formulas show them. */
const GREEK = { phi: 'φ', rho: 'ρ' };

/** The name of a parameter of an effect or fault; those of a law or own effect are symbols. */
export const parameterName = ({ law }, name) => (law ? GREEK[name] ?? name : words(name));

/** A fault of the data: what was seen, and what was done about it. */
export function dataFault(fault) {
  const joints = fault.joints.length ? ` on ${fault.joints.join(', ')}` : '';
  return h('article', { class: 'finding', 'data-fault': fault.code }, h('h3', {}, faultName(fault.code), `${joints} `, fault.code === 'filtered_torque' ? h('span', { class: 'tag' }, 'allowed for') : h('span', { class: 'tag bad' }, term('data_fault', 'fault of the data'))),
    h('p', { class: 'sentence' }, said(sentence(fault.detail))), h('p', { class: 'soft' }, said(fault.remedy)), findingParameters(fault));
}

/** Whether a finding is a part of the model, where it is not. */
export function outside(finding) {
  if (finding.in_model) return null;
  return finding.held_out.change === 'not_tested' ? h('span', { class: 'tag' }, 'not in the model: temporary') : h('span', { class: 'tag warn' }, 'not in the model: contradicted by held-out data');
}

/** [finding, place in the list of the interface], the greatest share of the held-out error that it removes first. */
export function byGain(findings) {
  const share = ({ held_out: { before, after } }) => (before > 0 ? 1 - after / before : -Infinity);
  return findings.map((f, i) => [f, i]).sort(([a], [b]) => share(b) - share(a));
}

const CHANGES = { better: ['good', 'better'], worse: ['bad', 'worse'], same: ['', 'no significant change'], not_tested: ['', 'not tested'] };
/** Whether the held-out error changed, in words. */
export const changed = (change) => CHANGES[change]?.[1] ?? words(change);

/** What it does to the error on data that the fit did not see, in one figure. */
export function gain(finding, effort) {
  const { before, after, change } = finding.held_out;
  const [kind, text] = CHANGES[change] ?? ['', words(change)];
  const tested = Number.isFinite(before) && Number.isFinite(after);
  return h('dl', { class: 'figures' }, figure(term('held_out', 'Held-out error'), tested ? `${number(before, 3)} → ${number(after, 3)}` : '–', [tested ? `${effort} ` : null, h('span', { class: `tag ${kind}` }, text)]));
}

/** Torques and energy of a law as formulas. */
export function lawFormulas({ law }) {
  if (!law) return null;
  const rows = [...law.torques.map((t) => [`Torque of ${t.joint}`, t.expression]), ...(law.energy ? [['Energy', law.energy]] : [])].map(([name, text], i) => ({ name, text, set: law.mathml?.length ? formula(law.mathml[i]) : null }));
  return table([{ head: 'Of', hidden: true, cell: (r) => r.name }, { head: 'Formula', hidden: true, cell: (r) => r.set ?? r.text }], rows, { caption: 'Formulas of the law' });
}

/** Its parameters with one standard deviation. */
export function findingParameters(finding) {
  if (!finding.parameters.length) return null;
  return table([
    { head: 'Parameter', cell: (p) => parameterName(finding, p.name) }, { head: 'Value', number: true, cell: (p) => `${measured(p.value, p.std_dev)} ${unit(p.unit === '1' ? '' : p.unit)}` },
  ], finding.parameters, { caption: 'Estimate ± standard deviation' });
}

/** How many periods the fitted rows are means over; 1 where nothing repeats. */
export function periodsAveraged(logs) {
  const of = (log) => Number(/^(\d+) periods/.exec(log.choices.find((c) => c.what === 'averaging')?.value ?? '')?.[1] ?? 1);
  return logs.length ? Math.min(...logs.map(of)) : 1;
}
