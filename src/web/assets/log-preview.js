// What was understood of logs before anything runs.
import { fill, figure, h, number, perSecond, said, sentence, sinceStart, table, term, unit, words } from './dom.js';
import { faultName } from './finding.js';
import { colour, plotLater } from './plot.js';

export async function showPreview(target, seen) {
  fill(target, seen.notes.length ? h('div', { class: 'notice' }, seen.notes.map((n) => h('p', {}, said(sentence(n))))) : null, seen.logs.map(logCard));
}

/** In a few words, beside the button. */
export function inShort({ logs }) {
  const remarks = logs.reduce((sum, log) => sum + log.faults.length + log.findings.length + (log.periods < 2), 0);
  const read = `${logs.length === 1 ? 'Log' : `${logs.length} logs`} read`;
  return remarks ? `${read}, ${remarks} remark${remarks > 1 ? 's' : ''}` : `${read}, no faults`;
}

function logCard(log, index) {
  const trouble = [...log.faults, ...log.findings];
  const repeats = log.periods >= 2 ? `${log.periods} of ${number(log.period_s)} s` : 'none';
  return h('section', { class: 'card' }, h('h2', {}, log.file, ' ', h('span', { class: 'tag' }, log.role === 'identification' ? 'identification' : 'validation')),
    h('dl', { class: 'figures' }, figure('Rows', log.rows_used.toLocaleString(), log.rows_used < log.rows ? `of ${log.rows.toLocaleString()}` : null), figure('Rate', number(log.sample_rate_hz), 'Hz'),
      figure('Length', number(log.duration_s), 's'), figure(term('period_log', 'Periods'), repeats)),
    log.periods < 2 ? h('div', { class: 'notice' }, h('p', {}, 'The motion does not repeat in this log. Noise cannot be measured separately, and small effects will be missed. Run the trajectory several times in a row.')) : null,
    trouble.length ? h('div', { class: 'notice' }, trouble.map(problem)) : h('div', { class: 'notice good' }, h('p', {}, 'No faults found: no gaps or invalid values; signs and units are plausible.')),
    columns(log.columns), motion(log, index), choices(log.choices));
}

/** A step of the preparation, with help where it is a term. */
export const step = (what) => (STEPS[what] ? term(STEPS[what], words(what)) : words(what));
const STEPS = { decimation: 'decimation', period: 'period', averaging: 'period_log', method: 'preparation' };

const problem = (f) => h('p', {}, h('strong', {}, faultName(f.code)), ': ', said(f.detail), f.lines?.length ? ` (lines ${f.lines.slice(0, 5).join(', ')}${f.count > 5 ? ' …' : ''})` : '');

function columns(found) {
  const line = (name, list) => (list.length ? h('div', {}, h('strong', {}, `${name}: `), h('span', { class: 'mono' }, list.join(', '))) : null);
  return h('details', { class: 'field' }, h('summary', {}, 'Columns as read'), line('Time', found.time ? [found.time] : []), line('Positions', found.position), line('Velocities', found.velocity), line('Torques', found.torque), line('Not used', found.unused));
}

function choices(list) {
  return h('details', {}, h('summary', {}, 'Preparation'), table([
    { head: 'Step', term: 'preparation', cell: (c) => step(c.what) }, { head: 'Choice', cell: (c) => c.value }, { head: 'Reason', cell: (c) => said(c.why) },
  ], list, { caption: 'Decisions of the preparation' }));
}

function motion(log, index) {
  const chart = h('div', { class: 'plot', 'data-label': 'Positions and torques of the log as understood' });
  plotLater(chart, () => ({
    traces: log.joints.flatMap((joint, j) => [
      { type: 'scatter', mode: 'lines', name: joint.joint, legendgroup: joint.joint, x: sinceStart(joint.time), y: joint.position, line: { color: colour(j), width: 1.2 } },
      { type: 'scatter', mode: 'lines', name: joint.joint, legendgroup: joint.joint, showlegend: false, x: sinceStart(joint.time), y: joint.torque, yaxis: 'y2', line: { color: colour(j), width: 1.2 } },
    ]),
    layout: { height: 360, hovermode: 'closest', yaxis: { domain: [0.54, 1], title: `position<br>(${units(log, 'position_unit')})` }, yaxis2: { domain: [0, 0.46], title: `torque<br>(${units(log, 'effort_unit')})` }, xaxis: { title: 'time (s)', anchor: 'y2' } },
  }));
  return h('div', {}, h('h3', { id: `motion-${index}` }, 'Motion and torque, as read'), chart, h('details', {}, h('summary', {}, 'Per joint'), table([
    { head: 'Joint', cell: (j) => j.joint }, { head: 'Positions', number: true, cell: (j) => `${number(j.position_range[0], 3)} … ${number(j.position_range[1], 3)} ${j.position_unit}` },
    { head: 'Of its range', term: 'range_used', number: true, cell: (j) => (j.range_used === null ? '–' : `${number(100 * j.range_used, 2)} %`), sort: (j) => j.range_used },
    { head: 'Top speed', number: true, cell: (j) => `${number(j.top_speed, 3)} ${perSecond(j.position_unit, 1)}`, sort: (j) => j.top_speed },
    { head: 'Torques', number: true, cell: (j) => `${number(j.torque_range[0], 3)} … ${number(j.torque_range[1], 3)} ${unit(j.effort_unit)}` },
  ], log.joints, { caption: 'Ranges in SI units' })));
}

const units = (log, key) => [...new Set(log.joints.map((j) => unit(j[key])))].join(' or ');
