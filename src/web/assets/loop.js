// The loop: noise floor, what is left, findings, before and after, rivals and what would decide.
import { explain, getJson, postJson } from './api.js';
import { decision } from './decide.js';
import { fill, figure, find, h, measured, number, table, time, unit, words } from './dom.js';
import { RESIDUAL, reportLink } from './identify-result.js';
import { colour, plotLater, variable } from './plot.js';
import { residualPlot } from './residual-plot.js';

const section = (id, title, ...parts) => h('section', { class: 'card', id, 'aria-labelledby': `${id}-title` }, h('h2', { id: `${id}-title` }, title), parts);

async function show(id) {
  const result = await getJson(`/identify/${id}`);
  const target = find('#result');
  const report = result.residual;
  if (!report) {
    fill(target, section('none', result.robot, h('p', {}, 'This identification was asked not to trace what is left. '), h('a', { class: 'button', href: `/identification?id=${id}` }, 'See its result')));
    return;
  }
  const drawn = result.provenance ? await postJson('/motion', { robot: result.provenance.robot }) : null;
  const context = { result, report, effort: result.joints.map((_, j) => unit(drawn?.joints[j].effort_unit ?? 'N m')), position: result.joints.map((_, j) => drawn?.joints[j].position_unit ?? 'rad') };
  const parts = [['summary', 'Verdict'], ['findings', 'Findings'], ['bars', 'Before and after'], ['dependence', 'Dependence'], ['floor', 'Noise floor'], ['next', 'Next']];
  fill(target, h('nav', { class: 'toc', 'aria-label': 'Parts' }, parts.map(([name, text]) => h('a', { href: `#${name}` }, text))),
    summary(context), findings(context), bars(context), residualPlot(context), floor(context), next(context));
}

function summary({ result, report }) {
  const [kind, text] = RESIDUAL[report.verdict] ?? ['', words(report.verdict)];
  const heldOut = report.rms_before.held_out.length > 0;
  const sum = (list) => list.reduce((a, b) => a + b, 0);
  const of = (pair) => (heldOut ? pair.held_out : pair.identification);
  return section('summary', result.robot, h('p', {}, h('span', { class: `tag ${kind}` }, words(report.verdict)), ' ', h('strong', { id: 'verdict' }, text)),
    h('dl', { class: 'figures' }, figure('Findings', report.findings.length), figure('Error before', number(sum(of(report.rms_before)), 3), `summed over joints, ${heldOut ? 'held-out' : 'identification'} data`),
      figure('After', number(sum(of(report.rms_after)), 3)), figure('Noise alone', number(sum(report.noise_floor), 3))),
    heldOut ? null : h('div', { class: 'notice' }, h('p', {}, 'There is no held-out log: before and after are told on the data that chose the effects. Give a validation log to know.')),
    h('div', { class: 'row' }, h('a', { class: 'button', href: `/identification?id=${result.id}` }, 'The identification'), reportLink(result)));
}

function findings(context) {
  const { report } = context;
  const cards = report.findings.map((f) => finding(context, f));
  if (report.remainder) cards.push(remainder(context));
  if (!cards.length) cards.push(h('p', {}, 'Nothing stands out of the noise. The declared model says all that these logs can say.'));
  return section('findings', 'Findings', h('div', {}, cards));
}

const listed = (names) => (names.length > 1 ? `${names.slice(0, -1).join(', ')} and ${names.at(-1)}` : names[0] ?? '');
const where = (joints, all) => (joints.length === all.length && all.length > 1 ? 'the whole robot' : listed(joints));

/** A finding in one sentence with its figures. */
function sentence({ result }, f) {
  const values = f.parameters.map((p) => `${words(p.name).toLowerCase()} ${measured(p.value, p.std_dev)} ${unit(p.unit)}`.trim());
  return h('p', { class: 'sentence' }, h('strong', {}, words(f.effect)), ` on ${where(f.joints, result.joints)}`, values.length ? `: ${listed(values)}.` : '.');
}

function effectOnError({ result, report, effort }, f) {
  const heldOut = f.rms_before.held_out.length > 0;
  const of = (pair) => (heldOut ? pair.held_out : pair.identification);
  // The joints whose error changes most; an effect of the whole robot changes many.
  const changed = result.joints.map((name, j) => ({ name, j, before: of(f.rms_before)[j], after: of(f.rms_after)[j] })).sort((a, b) => (b.before - b.after) / b.before - (a.before - a.after) / a.before);
  const shown = changed.filter((c) => f.joints.includes(c.name)).slice(0, 3);
  const one = (c) => `${c.name} ${number(c.before, 3)} → ${number(c.after, 3)} ${effort[c.j]} (noise alone ${number(report.noise_floor[c.j], 3)})`;
  return h('p', {}, `Error on ${heldOut ? 'held-out' : 'identification'} data: ${shown.map(one).join('; ')}.`);
}

function finding(context, f) {
  const e = f.evidence;
  const fault = f.parameters.length === 0 && e.gain === 0;
  const evidence = fault ? null : h('p', { class: 'soft' }, `Twice the log of the evidence ratio is ${number(e.log_evidence_ratio, 3)}; chance of such a gain without it ${e.p_value < 1e-12 ? 'below 10⁻¹²' : number(e.p_value, 2)}. `,
    `On blocks of time that were left out of the fit it explains ${number(e.held_out_blocks, 3)} times the noise’s variance${e.held_out_periods === null ? '' : `, on the other half of the periods ${number(e.held_out_periods, 3)} times`}.`);
  return h('article', { class: 'finding', 'data-effect': f.effect }, sentence(context, f), effectOnError(context, f), f.note ? h('p', {}, f.note) : null, evidence, rivals(context, f));
}

function rivals(context, f) {
  if (!f.rivals.length) return null;
  const one = (r) => h('li', {}, h('strong', {}, words(r.effect)), ` on ${where(r.joints, context.result.joints)}: `, r.evidence > 0 ? `less likely by ${number(r.evidence, 3)} (twice the log of the evidence ratio), but not excluded` : `fits better by ${number(-r.evidence, 3)}`);
  return h('div', {}, h('h3', {}, 'It could also be'), h('ul', {}, f.rivals.map(one)), h('p', {}, h('a', { href: '#next' }, 'What would decide')));
}

function remainder(context) {
  const r = context.report.remainder;
  const rms = r.joints.map((name, i) => `${name} ${number(r.rms[i], 3)} ${context.effort[context.result.joints.indexOf(name)]}`);
  return h('article', { class: 'finding', 'data-effect': 'unexplained' }, h('p', { class: 'sentence' }, h('strong', {}, 'Unexplained'), ` on ${listed(r.joints)}: it depends on ${listed(r.depends_on)}.`),
    h('p', {}, `Above the noise there are left ${listed(rms)}; smooth functions of these variables predict ${number(100 * r.predicted_share, 3)} % of it.`), h('p', {}, r.note));
}

function bars({ result, report, effort }) {
  const kinds = [['identification', 'On the data that made the model'], ['held_out', 'On held-out data']].filter(([k]) => report.rms_before[k].length);
  const charts = kinds.map(([kind, title]) => {
    const chart = h('div', { class: 'plot', 'data-label': `Error per joint before and after, ${title}` });
    plotLater(chart, () => ({
      traces: [
        { type: 'bar', name: 'declared model', x: result.joints, y: report.rms_before[kind], marker: { color: colour(1), pattern: { shape: '/' } } },
        { type: 'bar', name: 'with the effects found', x: result.joints, y: report.rms_after[kind], marker: { color: colour(0) } },
        { type: 'scatter', mode: 'markers', name: 'noise floor', x: result.joints, y: report.noise_floor, marker: { symbol: 'line-ew-open', size: innerWidth < 640 ? 16 : 30, line: { width: 3, color: variable('--ink') }, color: variable('--ink') } },
      ].map((t) => ({ ...t, hovertemplate: '%{y:.4g}' })),
      layout: { barmode: 'group', height: 310, xaxis: { type: 'category', title: 'joint' }, yaxis: { title: `RMS error (${[...new Set(effort)].join(' or ')})`, rangemode: 'tozero' } },
    }));
    return h('div', {}, h('h3', {}, title), chart);
  });
  return section('bars', 'Before and after', h('div', { class: 'columns' }, charts));
}

function floor({ result, report, effort }) {
  const rows = result.joints.map((name, j) => ({ name, j, floor: report.noise_floor[j], fit: report.lack_of_fit[j], after: report.lack_of_fit_after[j] }));
  const p = (v) => (v < 1e-12 ? '< 10⁻¹²' : number(v, 2));
  return section('floor', 'Noise floor and lack of fit', h('p', { class: 'soft' }, `Noise from: ${report.noise_source}. Lack of fit compares what is left with what noise alone would leave: 1 means nothing is missing.`), table([
    { head: 'Joint', cell: (r) => r.name, sort: (r) => r.name }, { head: 'Noise floor', number: true, cell: (r) => `${number(r.floor, 3)} ${effort[r.j]}`, sort: (r) => r.floor, title: 'Standard deviation of one measurement' },
    { head: 'Left (mean)', number: true, cell: (r) => number(r.fit.residual_rms, 3), sort: (r) => r.fit.residual_rms, title: 'RMS of the residual of the mean over the periods' }, { head: 'Noise alone (mean)', number: true, cell: (r) => number(r.fit.expected_rms, 3), sort: (r) => r.fit.expected_rms },
    { head: 'Lack of fit', number: true, cell: (r) => number(r.fit.statistic, 3), sort: (r) => r.fit.statistic }, { head: 'p', number: true, cell: (r) => p(r.fit.p_value), sort: (r) => r.fit.p_value },
    { head: 'After', number: true, cell: (r) => number(r.after?.statistic, 3), sort: (r) => r.after?.statistic }, { head: 'p', number: true, cell: (r) => p(r.after?.p_value), sort: (r) => r.after?.p_value },
  ], rows, { caption: 'Per joint' }));
}

function next(context) {
  const { report } = context;
  const rivals = report.findings.flatMap((f) => f.rivals.map((r) => `${words(f.effect).toLowerCase()} or ${words(r.effect).toLowerCase()}`));
  const text = rivals.length ? `Open: ${listed(rivals)}. On the motion that was run these move the torque alike. A motion through other positions, speeds and loads can tell them apart.`
    : report.remainder ? 'What is left depends on the variables above; a motion that passes through other combinations of them shows more of it.'
      : 'Another motion, through other positions, speeds and loads, is the test that these findings must pass: nothing new should be found on it.';
  return section('next', 'What to record next', h('p', {}, text, ' Run it, and identify from both logs together.'), decision(context));
}

async function begin() {
  const { jobs } = await getJson('/jobs');
  const done = jobs.filter((j) => j.kind === 'identification' && j.state === 'finished');
  const asked = new URLSearchParams(location.search).get('id');
  const which = find('#which');
  const chosen = asked ?? done[0]?.id;
  if (asked && !done.some((j) => j.id === asked)) done.unshift({ id: asked, finished_at: new Date().toISOString() });
  fill(which, done.map((j) => h('option', { value: j.id, selected: j.id === chosen }, `${time(j.finished_at)}  ${j.id.slice(0, 8)}`)));
  which.addEventListener('change', () => { location.search = `?id=${which.value}`; });
  if (!chosen) {
    fill(find('#result'), section('none', 'Nothing yet', h('p', {}, 'There is no identification. '), h('a', { class: 'button primary', href: '/identification' }, 'Identify from a log')));
    return;
  }
  await show(chosen);
}

begin().catch((e) => explain(find('#trouble'), e));
