// Diagnosis: verdict, findings, errors before and after, noise floor, rivals and the experiment that decides.
import { explain, getJson, postJson } from './api.js';
import { designButton } from './decide.js';
import { fill, figure, find, h, number, odds, said, table, term, time, unit, words } from './dom.js';
import { byGain, changed, dataFault, effectName, findingParameters, gain, lawFormulas, outside } from './finding.js';
import { RESIDUAL, reportLink } from './identify-result.js';
import { colour, plotLater, plotly, variable } from './plot.js';
import { residualPlot } from './residual-plot.js';

const section = (id, title, ...parts) => h('section', { class: 'card', id, 'aria-labelledby': `${id}-title` }, h('h2', { id: `${id}-title` }, title), parts);

async function show(id) {
  const result = await getJson(`/identify/${id}`);
  const target = find('#result');
  const report = result.residual;
  if (!report) {
    fill(target, section('none', result.robot, h('p', {}, 'This identification was run without residual diagnosis. '), h('a', { class: 'button', href: `/identification?id=${id}` }, 'See its result')));
    return;
  }
  const drawn = result.provenance ? await postJson('/motion', { robot: result.provenance.robot }) : null;
  const context = { result, report, effort: result.joints.map((_, j) => unit(drawn?.joints[j].effort_unit ?? 'N m')), position: result.joints.map((_, j) => drawn?.joints[j].position_unit ?? 'rad') };
  const parts = [['summary', 'Verdict'], ['findings', 'Findings'], ['bars', 'Errors'], ['dependence', 'Residual'], ['floor', 'Lack of fit'], ...(report.undetected?.length ? [['undetected', 'Not found']] : []), ['next', 'Next experiment']];
  fill(target, h('nav', { class: 'toc', 'aria-label': 'Parts' }, parts.map(([name, text]) => h('a', { href: `#${name}` }, text))),
    summary(context), findings(context), bars(context), residualPlot(context), floor(context), undetected(context), next(context));
}

function summary({ result, report, effort: units }) {
  const effort = [...new Set(units)].join(' or ');
  const [kind, text] = RESIDUAL[report.verdict] ?? ['', words(report.verdict)];
  const heldOut = report.rms_before.held_out.length > 0;
  const sum = (list) => list.reduce((a, b) => a + b, 0);
  const of = (pair) => (heldOut ? pair.held_out : pair.identification);
  return section('summary', result.robot, h('p', {}, h('span', { class: `tag ${kind}` }, term('verdict', words(report.verdict))), ' ', h('strong', { id: 'verdict' }, said(report.summary ?? text))),
    h('dl', { class: 'figures' }, figure(term('finding', 'Findings'), report.findings.length, `${report.findings.filter((f) => f.in_model).length} in the model`), figure(term('rms_error', 'Error without the effects'), number(sum(of(report.rms_before)), 3), `${effort}, summed over joints; ${heldOut ? 'held-out' : 'identification'} data`),
      figure('Error with the effects', number(sum(of(report.rms_after)), 3)), figure(term('noise_floor', 'Noise floor'), number(sum(report.noise_floor), 3))),
    heldOut ? null : h('div', { class: 'notice' }, h('p', {}, 'There is no validation log: these are errors on the data that chose the effects. Blocks of the log were held out in turn instead, which is weaker evidence.')),
    h('div', { class: 'row' }, h('a', { class: 'button', href: `/identification?id=${result.id}` }, 'Open the identification'), reportLink(result, 'Open the report')));
}

function findings(context) {
  const { report } = context;
  const shown = byGain(report.findings).map(([f, i]) => [f, finding(context, f, i)]);
  const small = ([f]) => f.held_out.change === 'same';
  const folded = shown.filter(small).map(([, card]) => card);
  const cards = [...report.data_faults.map(dataFault), ...shown.filter((s) => !small(s)).map(([, card]) => card)];
  if (folded.length) cards.push(h('details', { id: 'small-findings', open: !cards.length }, h('summary', {}, `${folded.length === 1 ? 'One effect' : `${folded.length} effects`} without a significant change of the held-out error`), folded));
  if (report.remainder) cards.push(remainder(context));
  if (!cards.length) cards.push(h('p', {}, 'The residual is noise: these logs show no effect beyond the declared model.'));
  return section('findings', [term('finding', 'Findings')], h('div', {}, cards));
}

const listed = (names, last = 'and') => (names.length > 1 ? `${names.slice(0, -1).join(', ')} ${last} ${names.at(-1)}` : names[0] ?? '');
const where = (joints, all) => (joints.length === all.length && all.length > 1 ? 'the whole robot' : listed(joints));
const called = (effect, all) => `${words(effect.effect).toLowerCase()} on ${where(effect.joints, all)}`;

/** A finding: name, its sentence in the words of the interface, its figures, what else it could be. */
function finding(context, f, index) {
  const e = f.evidence;
  const evaluated = (v, text) => (v === 'not_evaluated' ? 'not evaluated' : text(v));
  const chance = (p) => evaluated(p, (v) => (v < 1e-12 ? 'below 10⁻¹²' : number(v, 2)));
  const three = (v) => evaluated(v, (x) => number(x, 3));
  const held = f.held_out;
  const figures = [
    [term('bic', 'Difference in BIC'), number(e.log_evidence_ratio, 3)], [term('p_value', 'p of the gain'), chance(e.p_value)],
    [term('prediction_gain', 'Gain on blocks of time left out of the fit'), three(e.held_out_blocks)], ['Gain on the other half of the periods', three(e.held_out_periods)],
    [term('held_out', 'Held-out error without the effect'), three(held.before)], ['Held-out error with the effect', three(held.after)], ['Change of the held-out error', changed(held.change)], [term('p_value', 'p of the change'), chance(held.p_value)],
  ];
  const evidence = h('details', {}, h('summary', {}, 'Evidence'), table([{ head: 'Evidence', cell: (r) => r[0] }, { head: 'Figure', hidden: true, number: true, cell: (r) => r[1] }], figures, { caption: 'Evidence for the finding' }));
  return h('article', { class: 'finding', 'data-effect': f.effect }, h('h3', {}, effectName(f), ` on ${where(f.joints, context.result.joints)} `, outside(f)),
    gain(f, context.effort[context.result.joints.indexOf(f.joints[0])] ?? 'N·m'), h('p', { class: 'sentence' }, said(f.sentence)), f.note ? h('p', { class: 'soft' }, said(`Note: ${f.note}.`)) : null, lawFormulas(f), findingParameters(f), evidence, survivals(f), rivals(context, f, index));
}

/** Whether it is found again when the data are changed a little. */
function survivals(f) {
  if (!f.survivals?.length) return null;
  const lost = f.survivals.filter((s) => !s.survives).length;
  return h('details', {}, h('summary', {}, `Found again in ${f.survivals.length - lost} of ${f.survivals.length} changed copies of the data`),
    table([{ head: 'Change of the data', term: 'survival', cell: (s) => words(s.perturbation) }, { head: 'Finding', term: 'finding', cell: (s) => h('span', { class: `tag ${s.survives ? 'good' : 'warn'}` }, s.survives ? 'found again' : 'not found') }], f.survivals, { caption: 'The same diagnosis from changed data' }));
}

/** How the evidence stands between a finding and a rival. */
function against(evidence) {
  if (Math.abs(evidence) < 0.1) return ': fits equally well, but is the rarer cause.';
  return evidence > 0 ? `: ${odds(evidence)} against it, which does not exclude it (difference in BIC ${number(evidence, 3)}; 20 to 1 is 6).` : `: fits better (difference in BIC ${number(-evidence, 3)}), but is the rarer cause.`;
}

function rivals(context, f, index) {
  if (!f.rivals.length) return null;
  const all = context.result.joints;
  const one = (r, k) => h('li', {}, h('p', {}, h('strong', {}, words(called(r, all))), against(r.evidence)),
    context.result.provenance ? designButton(context, `Design the trajectory that decides: ${words(f.effect).toLowerCase()} or ${words(r.effect).toLowerCase()}`, { finding: { effect: f.effect, joints: f.joints }, rival: { effect: r.effect, joints: r.joints } }, `decide-${index}-${k}`) : null);
  return h('div', { class: 'rivals' }, h('h4', {}, term('rival', 'It could also be')), h('ul', { class: 'list' }, f.rivals.map(one)));
}

function remainder(context) {
  const r = context.report.remainder;
  return h('article', { class: 'finding', 'data-effect': 'unexplained' }, h('h3', {}, term('remainder', 'Unexplained'), ` on ${where(r.joints, context.result.joints)}`), h('p', { class: 'sentence' }, said(r.sentence)), h('p', { class: 'soft' }, said(r.note)));
}

function bars({ result, report, effort }) {
  const kinds = [['identification', 'Identification data'], ['held_out', 'Held-out data']].filter(([k]) => report.rms_before[k].length);
  // Joints of the wrist have errors of a hundredth of those of the shoulder: all are seen as multiples of their noise.
  const relative = report.noise_floor.every((v) => v > 0);
  const over = (list) => (relative ? list.map((v, j) => v / report.noise_floor[j]) : list);
  const charts = kinds.map(([kind, title]) => {
    const chart = h('div', { class: 'plot', 'data-label': `Error per joint before and after, ${title}` });
    plotLater(chart, () => ({
      traces: [
        { type: 'bar', name: 'declared model', x: result.joints, y: over(report.rms_before[kind]), customdata: report.rms_before[kind], marker: { color: colour(1), pattern: { shape: '/' } } },
        { type: 'bar', name: 'with the effects found', x: result.joints, y: over(report.rms_after[kind]), customdata: report.rms_after[kind], marker: { color: colour(0) } },
        { type: 'scatter', mode: 'markers', name: 'noise floor', x: result.joints, y: over(report.noise_floor), customdata: report.noise_floor, marker: { symbol: 'line-ew-open', size: innerWidth < 640 ? 16 : 30, line: { width: 3, color: variable('--ink') }, color: variable('--ink') } },
      ].map((t) => ({ ...t, hovertemplate: `%{customdata:.4g} ${[...new Set(effort)].join(' or ')}` })),
      layout: { barmode: 'group', height: 310, xaxis: { type: 'category', title: 'joint' }, yaxis: { title: relative ? 'RMS error over<br>noise floor (ratio)' : `RMS error<br>(${[...new Set(effort)].join(' or ')})`, rangemode: 'tozero' } },
    }));
    return h('div', {}, h('h3', {}, title), chart);
  });
  return section('bars', 'Errors without and with the effects', h('p', { class: 'soft' }, 'Both models are estimated from the same rows with the same weights. Without the effects, the fit compensates for a part of them by wrong base parameters, which also moves errors to other joints.'),
    h('p', { class: 'soft', id: 'which-errors' }, 'Errors of single measurements, noise included: the same numbers as on the page of the identification.'),
    heldOutTable(report),
    h('div', { class: 'columns' }, charts));
}

const HELD_OUT = { confirmed: ['good', 'Held-out data confirm the effects'], not_confirmed: ['warn', 'Held-out data do not confirm the effects'], not_tested: ['', 'No effect is in the model'] };

/** Whether the error on held-out data changed beyond chance, joint by joint. */
function heldOutTable(report) {
  const held = report.held_out;
  if (held.verdict === 'not_tested') return null;
  const [kind, text] = HELD_OUT[held.verdict];
  return h('div', { id: 'held-out' }, h('p', {}, h('span', { class: `tag ${kind}` }, text), [' ', said(`Held-out data: ${held.source}.`)]), table([
    { head: 'Joint', cell: (j) => j.joint, sort: (j) => j.joint }, { head: 'Declared model', term: 'declared_model', number: true, cell: (j) => number(j.before, 3), sort: (j) => j.before }, { head: 'With the effects', number: true, cell: (j) => number(j.after, 3), sort: (j) => j.after },
    { head: 'Noise floor', term: 'noise_floor', number: true, cell: (j) => number(j.floor, 3), sort: (j) => j.floor }, { head: 'Change', term: 'held_out', cell: (j) => h('span', { class: `tag ${{ better: 'good', worse: 'bad' }[j.change] ?? ''}` }, changed(j.change)) }, { head: 'p', term: 'p_value', number: true, cell: (j) => (j.p_value < 1e-12 ? '< 10⁻¹²' : number(j.p_value, 2)), sort: (j) => j.p_value },
  ], held.joints, { caption: 'Held-out RMS error per joint (N·m, or N for prismatic joints)' }));
}

function floor({ result, report, effort }) {
  const rows = result.joints.map((name, j) => ({ name, j, floor: report.noise_floor[j], fit: report.lack_of_fit[j], after: report.lack_of_fit_after[j] }));
  const p = (v) => (v < 1e-12 ? '< 10⁻¹²' : number(v, 2));
  return section('floor', 'Noise floor and lack of fit', h('p', { class: 'soft' }, term('noise_source', 'Source of the noise'), `: ${report.noise_source}.`), table([
    { head: 'Joint', cell: (r) => r.name, sort: (r) => r.name }, { head: 'Noise floor', number: true, cell: (r) => `${number(r.floor, 3)} ${effort[r.j]}`, sort: (r) => r.floor, term: 'noise_floor' },
    { head: 'Residual RMS, averaged', term: 'residual', number: true, cell: (r) => number(r.fit.residual_rms, 3), sort: (r) => r.fit.residual_rms }, { head: 'From noise, averaged', term: 'noise_floor', number: true, cell: (r) => number(r.fit.expected_rms, 3), sort: (r) => r.fit.expected_rms },
    { head: 'Lack of fit', term: 'lack_of_fit', number: true, cell: (r) => number(r.fit.statistic, 3), sort: (r) => r.fit.statistic }, { head: 'p', term: 'p_value', number: true, cell: (r) => p(r.fit.p_value), sort: (r) => r.fit.p_value },
    { head: 'Lack of fit with effects', term: 'lack_of_fit', number: true, cell: (r) => number(r.after?.statistic, 3), sort: (r) => r.after?.statistic }, { head: 'p with effects', term: 'p_value', number: true, cell: (r) => p(r.after?.p_value), sort: (r) => r.after?.p_value },
  ], rows, { caption: 'Per joint; residual and noise are those of the rows of the fit, averaged over periods' }));
}

/** What every robot may have and these logs do not show: how large it could be. */
function undetected({ report }) {
  if (!report.undetected?.length) return null;
  const size = (p) => Math.abs(p.value) + 3 * p.std_dev;
  return section('undetected', [term('undetected', 'Effects tested and not found')], h('p', { class: 'soft' }, 'Each is estimated alone beside the final model. None is significant; a value of several deviations may still be real, and a longer log would show it. Effects that the base parameters or a finding already contain are not listed. Torque offsets marked as part of the model are estimated although none is significant alone: together they improve the prediction.'), table([
    { head: 'Effect', term: 'effect', cell: (r) => effectName(r), sort: (r) => r.effect }, { head: 'Joint', cell: (r) => r.joint, sort: (r) => r.joint },
    { head: 'Value', number: true, cell: (r) => number(r.parameter.value, 2), sort: (r) => r.parameter.value }, { head: 'σ', term: 'std_dev', number: true, cell: (r) => number(r.parameter.std_dev, 2), sort: (r) => r.parameter.std_dev },
    { head: 'Limit: |value| + 3σ', term: 'undetected', number: true, cell: (r) => number(size(r.parameter), 2), sort: (r) => size(r.parameter) }, { head: 'Unit', cell: (r) => unit(r.parameter.unit) }, ...(report.undetected.some((r) => r.in_model) ? [{ head: 'In the model', term: 'in_model', cell: (r) => (r.in_model ? 'yes' : 'no') }] : []),
  ], report.undetected, { caption: 'Effects without significance, with the size that they cannot exceed' }));
}

function next(context) {
  const { report, result } = context;
  const pairs = report.findings.flatMap((f) => f.rivals.map((r) => ({ finding: { effect: f.effect, joints: f.joints }, rival: { effect: r.effect, joints: r.joints } })));
  const [first] = pairs;
  const text = first ? `Open: ${listed(pairs.map((p) => `${called(p.finding, result.joints)} or ${called(p.rival, result.joints)}`), 'and')}. On the motion that was run they cause nearly the same torque. The next trajectory is designed to separate them.`
    : report.remainder?.depends_on.length && report.remainder.depends_on.every((name) => ['time', 'period'].includes(name)) ? 'The remaining residual changes over time and not with the motion: record again with a warm arm, and check whether it disappears.'
    : report.remainder?.depends_on[0] === 'time' && report.remainder.depends_on.every((name) => /^(time|qd\d+)$/.test(name)) ? 'Friction changes over the log: record a motion that repeats, whose periods tell how fast it does, or record with a warm arm.'
    : report.remainder?.depends_on.length === 0 ? 'The remaining residual depends on no pair of positions or velocities: look at it over time above, and record the same motion again to check whether it recurs.'
    : report.remainder ? 'The remaining residual depends on the variables above; a motion that passes through other combinations of them shows more of it.'
      : 'Test these findings on another motion: no new finding should appear. The next design complements these logs.';
  const label = first ? 'Design the deciding trajectory' : 'Design the next trajectory';
  return section('next', 'Next experiment', h('p', {}, text, ' Run it, and identify from both logs together.'), result.provenance ? designButton(context, label, first, 'decide') : null);
}

async function begin() {
  const { jobs } = await getJson('/jobs');
  const done = jobs.filter((j) => j.kind === 'identification' && j.state === 'finished');
  const asked = new URLSearchParams(location.search).get('id');
  const which = find('#which');
  const chosen = asked ?? done[0]?.id;
  if (asked && !done.some((j) => j.id === asked)) done.unshift({ id: asked });
  fill(which, done.map((j) => h('option', { value: j.id, selected: j.id === chosen }, [j.finished_at && time(j.finished_at), j.robot, j.id.slice(0, 8)].filter(Boolean).join(' · '))));
  which.addEventListener('change', () => { location.search = `?id=${which.value}`; });
  if (!chosen) {
    fill(find('#result'), section('none', 'Nothing yet', h('p', {}, 'There is no identification. '), h('a', { class: 'button primary', href: '/identification' }, 'Identify from a log')));
    return;
  }
  plotly();
  await show(chosen);
}

begin().catch((e) => explain(find('#trouble'), e));
