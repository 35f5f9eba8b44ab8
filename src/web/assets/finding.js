// Parts of a finding that several pages show.
import { h, measured, sentence, table, unit, words } from './dom.js';

/** A fault of the data: what was seen, and what was done about it. */
export function dataFault(fault) {
  const joints = fault.joints.length ? ` on ${fault.joints.join(', ')}` : '';
  return h('article', { class: 'finding', 'data-fault': fault.code }, h('h3', {}, `${words(fault.code)}${joints} `, h('span', { class: 'tag bad' }, 'fault of the data')),
    h('p', { class: 'sentence' }, sentence(fault.detail)), h('p', { class: 'soft' }, fault.remedy), findingParameters(fault));
}

/** Whether a finding is a part of the model, where it is not. */
export function outside(finding) {
  if (finding.in_model) return null;
  return finding.held_out.change === 'not_tested' ? h('span', { class: 'tag' }, 'not in the model: nothing that lasts') : h('span', { class: 'tag warn' }, 'not in the model: held-out data speak against it');
}

/** Its parameters with one standard deviation. */
export function findingParameters(finding) {
  if (!finding.parameters.length) return null;
  return table([
    { head: 'Parameter', cell: (p) => words(p.name) }, { head: 'Value', number: true, cell: (p) => `${measured(p.value, p.std_dev)} ${unit(p.unit === '1' ? '' : p.unit)}` },
  ], finding.parameters, { caption: 'With one standard deviation' });
}

/** How many periods the fitted rows are means over; 1 where nothing repeats. */
export function periodsAveraged(logs) {
  const of = (log) => Number(/^(\d+) periods/.exec(log.choices.find((c) => c.what === 'averaging')?.value ?? '')?.[1] ?? 1);
  return logs.length ? Math.min(...logs.map(of)) : 1;
}
