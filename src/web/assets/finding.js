// Parts of a finding that several pages show.
import { measured, table, unit, words } from './dom.js';

/** Its parameters with one standard deviation; none for a fault of the data. */
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
