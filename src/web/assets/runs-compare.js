// Two or more runs side by side: parameters with their deviations, errors per joint, findings; of designs their criteria.
import { getJson, summaryOf } from './api.js';
import { CRITERIA } from './criteria.js';
import { fill, h, measured, number, shortNames, table, term, time, unit } from './dom.js';
import { nameOf } from './expression.js';
import { effectName, parameterName } from './finding.js';
import { page, searchEnd } from './job-words.js';
import { colour, plot, plotLater, plotly } from './plot.js';

const section = (id, title, ...parts) => h('section', { class: 'card', id, 'aria-labelledby': `${id}-title` }, h('h2', { id: `${id}-title` }, title), parts);
/** Deviations beyond which two values differ more than chance lets them: one pair in three hundred does so by chance. */
const APART = 3;

export async function compareRuns(target, ids) {
  plotly();
  fill(target, h('section', { class: 'card' }, h('p', { class: 'soft' }, 'Loading the runs …')));
  const jobs = await Promise.all(ids.map((id) => getJson(`/jobs/${encodeURIComponent(id)}`)));
  const runs = (await Promise.all(jobs.map(async (job) => ({ job, result: await summaryOf(job) })))).sort((a, b) => a.job.created_at.localeCompare(b.job.created_at));
  const kinds = new Set(jobs.map((j) => j.kind));
  if (kinds.size > 1) {
    fill(target, section('compared', 'Comparison', h('p', {}, 'Runs of different kinds cannot be compared. Select designs only, or identifications only.')));
    return;
  }
  runs.forEach((run, i) => { run.label = run.job.name ?? `${time(run.job.finished_at)} (${run.job.id.slice(0, 4)})`; run.index = i; });
  fill(target, kinds.has('identification') ? identifications(runs) : designs(runs));
}

document.addEventListener('theme', () => document.querySelectorAll('.swatch').forEach((swatch) => { swatch.style.background = colour(swatch.dataset.colour); }));

const heads = (runs) => h('ul', { class: 'list' }, runs.map((run) => h('li', {}, h('span', { class: 'swatch', style: `background:${colour(run.index)}`, 'data-colour': run.index }), ' ', h('a', { href: page(run.job) }, run.label), ` for ${run.job.robot}`,
  run.result.log_report ? h('span', { class: 'soft' }, `, ${run.result.log_report.map((l) => l.file).join(', ')}`) : null, run.job.note ? h('div', { class: 'help note' }, run.job.note) : null)));

/** Parameters of different robots may share their names and be different quantities. */
function ofOneRobot(runs) {
  const robots = [...new Set(runs.map((run) => run.result.robot))];
  return robots.length > 1 ? h('div', { class: 'notice' }, h('p', {}, h('strong', {}, 'Different robots: '), `${robots.join(', ')}. Their values can be compared only where the kinematics are the same.`)) : null;
}

function identifications(runs) {
  return [section('compared', 'Comparison', heads(runs), ofOneRobot(runs)), parameters(runs), overTime(runs), errors(runs), findings(runs)];
}

/** Parameters that all have, each scaled to its mean so that all fit on one axis. */
function parameters(runs) {
  const names = runs[0].result.base_parameters.map((p) => p.name).filter((name) => runs.every((r) => r.result.base_parameters.some((p) => p.name === name)));
  if (!names.length) return section('parameters', 'Parameters', h('p', { class: 'soft' }, 'These robots have no base parameter in common.'));
  const of = (run, name) => run.result.base_parameters.find((p) => p.name === name);
  const rows = names.map((name) => ({ name, unit: of(runs[0], name).unit, all: runs.map((r) => of(r, name)) })).map((row) => ({ ...row, apart: apart(row.all) }));
  const chart = h('div', { class: 'plot', 'data-label': 'Differences of parameters from the first run, in the largest standard deviation of each, with two deviations either side' });
  plotLater(chart, () => ({
    traces: runs.map((run, i) => ({ type: 'scatter', mode: 'markers', name: run.label, x: rows.map((_, k) => k + 0.5 * (i / runs.length - 0.25)), y: rows.map((r) => scaled(r, i)[0]),
      error_y: { type: 'data', array: rows.map((r) => 2 * scaled(r, i)[1]), color: colour(i), thickness: 1.2, width: 3 }, marker: { color: colour(i), size: 6, symbol: ['circle', 'square', 'diamond', 'cross', 'x', 'triangle-up', 'star'][i % 7] }, hovertemplate: rows.map((r) => `${r.name}: ${r.all[i]?.value === null ? '–' : measured(r.all[i].value, r.all[i].std_dev)} ${unit(r.unit)}<extra>${run.label}</extra>`) })),
    layout: { height: 380, hovermode: 'closest', xaxis: { title: 'parameter', tickvals: rows.map((_, k) => k), ticktext: rows.map((r) => r.name), tickangle: -60, range: [-0.7, Math.min(rows.length, innerWidth < 640 ? 10 : 24) - 0.3] }, yaxis: { title: 'difference from the first run<br>(largest standard deviation)' } },
  }));
  const differ = rows.filter((r) => r.apart > APART).length;
  return section('parameters', [term('base_parameters', 'Base parameters')], h('p', {}, differ ? `${differ} of ${rows.length} parameters differ by more than ${APART} standard deviations between two of the runs.` : `No parameter differs by more than ${APART} standard deviations between any two runs.`), chart,
    table([{ head: 'Name', term: 'base_parameters', cell: (r) => nameOf(r.name), sort: (r) => r.name }, ...runs.map((run, i) => ({ head: run.label, own: true, number: true, cell: (r) => (r.all[i].value === null ? '–' : measured(r.all[i].value, r.all[i].std_dev)), sort: (r) => r.all[i].value })),
      { head: 'Unit', cell: (r) => unit(r.unit) }, { head: 'Largest difference (σ)', term: 'std_dev', number: true, cell: (r) => h('span', { class: r.apart > APART ? 'tag warn' : '' }, number(r.apart, 2)), sort: (r) => r.apart }], rows, { caption: 'Values ± standard deviation', sort: { column: runs.length + 2, way: 'descending' } }));
}

/** From a minute before the first date to a minute after the last: a single one has an axis as well. */
function around(dates) {
  const times = dates.map((date) => new Date(date).getTime());
  const margin = Math.max(0.05 * (Math.max(...times) - Math.min(...times)), 60_000);
  return [Math.min(...times) - margin, Math.max(...times) + margin].map((t) => new Date(t).toISOString());
}

/** One parameter over the dates of the runs; those that all runs have come first. */
function overTime(runs) {
  const of = (run, name) => run.result.base_parameters.find((p) => p.name === name);
  const everywhere = (name) => runs.every((run) => of(run, name));
  const names = runs[0].result.base_parameters.map((p) => p.name).sort((a, b) => everywhere(b) - everywhere(a));
  const choice = h('select', { class: 'narrow', id: 'over-time' }, names.map((name) => h('option', {}, name)));
  const chart = h('div', { class: 'plot flat', 'data-label': 'One base parameter over the dates of the runs, with two standard deviations either side' });
  const make = () => {
    const points = runs.map((run) => ({ run, p: of(run, choice.value) })).filter(({ p }) => p && p.value !== null);
    return {
      traces: [{ type: 'scatter', mode: 'lines+markers', x: points.map(({ run }) => run.job.finished_at), y: points.map(({ p }) => p.value), error_y: { type: 'data', array: points.map(({ p }) => 2 * p.std_dev), color: colour(1), thickness: 2, width: 6 },
        line: { color: colour(5), width: 1, dash: 'dot' }, marker: { size: 9, color: colour(0) }, hovertemplate: points.map(({ run, p }) => `${run.label}: ${measured(p.value, p.std_dev)}<extra></extra>`) }],
      layout: { height: 260, hovermode: 'closest', xaxis: { type: 'date', title: 'end of the identification', range: points.length ? around(points.map(({ run }) => run.job.finished_at)) : undefined }, yaxis: { title: `${choice.value} ± 2σ (${unit(of(runs[0], choice.value)?.unit)})` } },
    };
  };
  choice.addEventListener('change', () => plot(chart, make));
  plotLater(chart, make);
  return section('time', 'Over time', h('label', { class: 'inline', for: 'over-time' }, 'Parameter', choice), chart);
}

/** Difference from the first run and deviation, over the largest deviation of the parameter: a poor run does not press the others flat. */
function scaled(row, i) {
  const [first, own] = [row.all[0], row.all[i]];
  const size = Math.max(...row.all.map((p) => p?.std_dev ?? 0));
  if ([first?.value, own?.value].some((v) => v === null || v === undefined) || !(size > 0)) return [null, null];
  return [(own.value - first.value) / size, own.std_dev / size];
}

/** The largest difference between two values, over the deviation of that difference. */
function apart(all) {
  const known = all.filter((p) => p && p.value !== null && Number.isFinite(p.std_dev));
  const pairs = known.flatMap((a, i) => known.slice(i + 1).map((b) => Math.abs(a.value - b.value) / (Math.hypot(a.std_dev, b.std_dev) || Infinity)));
  return pairs.length ? Math.max(...pairs) : null;
}

function errors(runs) {
  const joints = [...new Set(runs.flatMap((run) => run.result.joints))];
  const at = (r, joint) => r.rms?.[r.joints.indexOf(joint)];
  const rows = runs.flatMap((run) => [['identification', run.result.rms.identification], ['validation', run.result.rms.validation]].flatMap(([role, logs]) => (logs ?? []).map((log) => ({ run: run.label, joints: run.result.joints, role, log: log.name, ...(log.base ?? log) }))));
  return section('errors', [term('rms_error', 'Errors'), ' per joint'], h('p', { class: 'soft' }, 'Root mean square of measured less predicted torque (N·m, or N for prismatic joints).'),
    table([{ head: 'Run', cell: (r) => r.run, sort: (r) => r.run }, { head: 'Log', cell: (r) => r.log, sort: (r) => r.log }, { head: 'Role', term: 'log_role', cell: (r) => r.role, sort: (r) => r.role }, ...shortNames(joints).map((name, j) => ({ head: name, own: true, number: true, cell: (r) => number(at(r, joints[j]), 3), sort: (r) => at(r, joints[j]) }))], rows, { caption: 'RMS errors' }));
}

function findings(runs) {
  const all = runs.map((run) => run.result.residual?.findings ?? []);
  const keys = [...new Set(all.flat().map((f) => `${f.effect}|${(f.joints ?? []).join(', ')}`))];
  const rows = keys.map((key) => { const [effect, joints] = key.split('|'); return { effect, joints, all: all.map((list) => list.find((f) => `${f.effect}|${(f.joints ?? []).join(', ')}` === key)) }; });
  if (!rows.length) return section('findings', 'Findings', h('p', { class: 'soft' }, 'No effect was found in any of them.'));
  const said = (f) => (f ? h('span', {}, (f.parameters ?? []).map((p, i) => [i ? '; ' : '', `${parameterName(f, p.name)} ${p.std_dev > 0 ? measured(p.value, p.std_dev) : number(p.value)} ${unit(p.unit === '1' ? '' : p.unit)}`])) : '–');
  return section('findings', [term('finding', 'Findings')], table([{ head: 'Effect', term: 'effect', cell: (r) => effectName({ effect: r.effect, law: r.all.find(Boolean)?.law }), sort: (r) => r.effect }, { head: 'Joints', cell: (r) => r.joints, sort: (r) => r.joints }, ...runs.map((run, i) => ({ head: run.label, own: true, cell: (r) => said(r.all[i]) }))], rows, { caption: 'Effects found, with their parameters' }));
}

function designs(runs) {
  const rows = Object.entries(CRITERIA).map(([key, c]) => ({ key, name: c.name, digits: c.digits, all: runs.map((r) => r.result.criteria?.[key] ?? (key === 'condition_number' ? r.result.condition_number : null)) })).filter((r) => r.all.some((v) => Number.isFinite(v)));
  const facts = [['Period (s)', (r) => r.period_s], ['Outcome', (r) => searchEnd(r.status)], ['Optimality criterion', (r) => CRITERIA[r.request?.criterion]?.name ?? '–']];
  return [section('compared', 'Comparison', heads(runs), ofOneRobot(runs)), section('criteria', 'Criteria', table([{ head: 'Criterion', cell: (r) => term(r.key, r.name) }, ...runs.map((run, i) => ({ head: run.label, own: true, number: true, cell: (r) => number(r.all[i], r.digits), sort: (r) => r.all[i] }))], rows, { caption: 'Smaller is better' }),
    table([{ head: 'Design', cell: (r) => r[0] }, ...runs.map((run) => ({ head: run.label, own: true, cell: (r) => { const v = r[1](run.result); return typeof v === 'number' ? number(v) : v; } }))], facts, { caption: 'How they were made' }))];
}
