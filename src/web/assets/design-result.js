// The result of a design.
import { getJson, postJson } from './api.js';
import { compareWith } from './compare.js';
import { CellView } from './cell-view.js';
import { CRITERIA, title } from './criteria.js';
import { courses } from './design-live.js';
import { fourierSeries } from './expression.js';
import { fill, figure, h, number, odds, perSecond, said, seconds, sentence, table, term, unit, words } from './dom.js';
import { searchEnd } from './job-words.js';
import { meshesOf } from './meshes.js';
import { on } from './known-form.js';
import { detectable } from './detectable.js';
import { downloads, earlier, identifyLink } from './design-downloads.js';
import { motionPlots } from './motion-plots.js';
import { player } from './player.js';
import { colour, plotLater, variable } from './plot.js';

const STATUS = {
  Converged: ['good', 'The search converged: no improvement over many evaluations.'],
  BudgetExhausted: ['', 'The criterion was still improving. A longer search gives a better trajectory.'],
  Stalled: ['warn', 'The search stopped improving early.'],
  Cancelled: ['warn', 'Stopped early with the best trajectory found. It satisfies every limit.'],
  Infeasible: ['bad', 'No motion of this kind is possible.'],
};

/** Evidence from which on the wrong cause counts as excluded. */
const DECISIVE = 6;

/** Fields of a request within a sentence of the interface, as the form calls them. */
const FIELDS = { 'constraints.space': 'the request', 'constraints.torque': 'the request', start_position: 'start position', torque_noise: 'the torque noise' };
const inWords = (text) => (text ?? '').replace(/constraints\.(space|torque)|start_position|torque_noise/g, (field) => FIELDS[field]).replace(/`([^`]*)`/g, '“$1”');

/** Why there is no motion, as a sentence: a link that stands in a floor may not touch it, two links may touch each other. */
export function reasonOf({ reason, joints }) {
  const between = joints.some((name) => (reason ?? '').includes(`from \`${name}\``));
  const text = inWords(reason).replace(/is -([\d.]+) m from/, (_, depth) => `reaches ${number(Number(depth))} m into`)
    .replace(/, a smaller clearance, or add the pair to self_collision\.ignore if it always touches/, between ? ', a smaller clearance, or let the pair touch if it always does' : ' or a smaller clearance, or move what is in the way');
  return sentence(text);
}

const section = (id, title, ...parts) => h('section', { class: 'card', id, 'aria-labelledby': `${id}-title` }, h('h2', { id: `${id}-title` }, title), parts);
const place = (label, flat) => h('div', { class: `plot${flat ? ' flat' : ''}`, 'data-label': label });

export async function showDesign(target, result) {
  if (!result.coefficients) {
    fill(target, section('summary', 'No trajectory', h('div', { class: 'problem' }, h('strong', {}, searchEnd(result.status)), h('p', {}, said(reasonOf(result)))), startPosture(result)), notes(result));
    return;
  }
  const trajectory = { fundamental_hz: result.fundamental_hz, coefficients: result.coefficients, offset: result.offset };
  const drawn = await postJson('/motion', { robot: result.request.robot, trajectory, samples: 1001 });
  const names = { summary: 'Summary', decides: 'Decides', criteria: 'Criteria', motion: 'Motion', path: 'Path', margins: 'Limits', clearances: 'Clearances', accuracy: 'Accuracy', detectable: 'Detectable', spectrum: 'Spectrum', coefficients: 'Coefficients', starts: 'Search', compare: 'Compare' };
  const space = result.request.constraints?.space;
  const shape = space ? drawn.shape : [];
  const played = player(drawn, space, { shape, clearances: result.clearances ?? [], meshes: meshesOf(result.request.robot, drawn) });
  // What was asked for comes first.
  const present = [evidence(result), summary(result), notes(result), criteria(result), motionPlots(drawn), played, margins(result), clearances(result, played), accuracy(result, await units(result)), detectable(result), spectrum(result, drawn), coefficients(result, drawn), starts(result), compareWith(result)].filter(Boolean);
  fill(target, h('nav', { class: 'toc', 'aria-label': 'Parts of the result' }, present.filter((p) => names[p.id]).map((p) => h('a', { href: `#${p.id}` }, names[p.id]))), present);
}

/** Where the motion would start, among the obstacles that the arm avoids. */
function startPosture(result) {
  const { space, start_position: start } = result.request.constraints ?? {};
  if (!space) return null;
  const cell = new CellView();
  cell.show(result.request.robot, space, start);
  return cell.element;
}

function notes(result) {
  return result.notes.length ? h('div', { class: 'notice' }, result.notes.map((n) => h('p', {}, said(sentence(n))))) : null;
}

function summary(result) {
  const [kind, meaning] = STATUS[result.status] ?? ['', ''];
  const c = result.criteria;
  const tightest = [...result.margins].sort((a, b) => a.margin - b.margin)[0];
  const used = result.search;
  return section('summary', result.robot,
    h('p', {}, h('span', { class: `tag ${kind}` }, term('search_end', searchEnd(result.status))), ' ', meaning),
    h('dl', { class: 'figures' }, figure(term('condition_number', 'Condition number'), number(c.condition_number)), figure(term('i_optimality', 'Prediction error'), number(c.i_optimality, 3), 'N·m per unit of noise'), figure(term('period', 'Period'), number(result.period_s), 's'),
      tightest ? figure(term('limit_margin', 'Smallest margin to a limit'), `${number(100 * tightest.margin, 2)} %`, `${tightest.joint}, ${tightest.quantity}`) : null),
    h('p', { class: 'soft' }, `${result.order} harmonics, ${used.evaluations.toLocaleString()} evaluations in ${seconds(used.elapsed_s)}, seed ${used.seed}. ${c.minimised === 'rival_evidence' ? 'Maximised: expected difference in BIC between the rivals' : `Minimised: ${title(c.minimised)}`}.`),
    downloads(result));
}

/** The causes between which evidence counts: a special case of the other leaves nothing over on any motion, unless the other has bounds. */
function counting(r) {
  const all = [['if_finding', r.finding, r.rival, 'finding'], ['if_rival', r.rival, r.finding, 'rival']];
  return all.filter(([key, , , which]) => which !== r.nested || r.expected_evidence.together[key] > 0);
}

/** How well the two causes can be distinguished: before, by the new trajectory, and by both; and how to go on. */
function evidence(result) {
  const r = result.rivals;
  if (!r) return null;
  const stages = [['recorded', 'recorded so far'], ['designed', 'this trajectory'], ['together', 'both together']].filter(([k]) => r.expected_evidence[k]);
  const of = (k) => r.expected_evidence[k];
  const cases = counting(r);
  const chart = place('Expected difference in BIC between the two causes, before and after', true);
  const shown_ = (v) => Math.max(v, 0.1);
  const most = Math.max(...stages.flatMap(([k]) => cases.map(([c]) => of(k)[c])));
  plotLater(chart, () => ({
    traces: cases.map(([key, cause], i) => ({ type: 'scatter', mode: 'lines+markers', name: `if it is ${on(cause)}`, y: stages.map((t) => t[1]), x: stages.map(([k]) => shown_(of(k)[key])), marker: { color: colour(i), size: 13, symbol: i ? 'diamond' : 'circle' }, line: { color: colour(i), width: 1, dash: 'dot' }, showlegend: true, hovertemplate: '%{x:.3g}<extra></extra>' })),
    layout: { height: 240, hovermode: 'closest', xaxis: { title: 'expected difference<br>in BIC (2 ln odds)', type: 'log', range: [-1.1, Math.max(Math.log10(most), 1.2) + 0.4], dtick: 1 }, yaxis: { type: 'category', autorange: 'reversed', title: 'data', range: [stages.length - 0.4, -0.6] },
      shapes: [{ type: 'line', yref: 'paper', y0: 0, y1: 1, x0: DECISIVE, x1: DECISIVE, line: { dash: 'dash', width: 1.5, color: variable('--bad') } }],
      annotations: [{ xref: 'x', x: Math.log10(DECISIVE), yref: 'paper', y: 0.99, yanchor: 'top', xanchor: 'left', text: '20 to 1', showarrow: false, font: { color: variable('--bad') } }] },
  }));
  const before = of('recorded');
  const run = result.request.periods > 1 ? ` run for ${result.request.periods} periods` : ' run';
  const open = cases.length === 1 ? `If it is ${on(cases[0][1])}, ` : '';
  const sentence_ = `${words(on(r.finding))}, or ${on(r.rival)}? ${open}${before ? `${open ? 'the' : 'The'} log so far is expected to separate them with ${odds(before.least)}; with` : `${open ? 'with' : 'With'}`} this trajectory${run} ${before ? 'too, ' : ''}it is ${of('together').least > 40 ? 'beyond doubt' : odds(of('together').least)}.`;
  const [special, general] = r.nested === 'finding' ? [r.finding, r.rival] : [r.rival, r.finding];
  return section('decides', 'Separation of the two causes',
    h('p', {}, h('span', { class: `tag ${r.decides ? 'good' : 'warn'}` }, r.decides ? 'Decides' : 'Does not decide'), ' ', h('strong', { class: 'sentence' }, sentence_)),
    h('p', { class: 'soft' }, r.nested ? `${words(on(special))} is a special case of ${on(general)}: if it is the true one both fit on any motion, the additional parameter of the other is estimated as zero within the deviations under “Accuracy”, and the odds for the simpler one grow slowly. ${cases.length === 1 ? 'The difference in BIC is given for the other case.' : 'The difference in BIC for it is that against the other with values that are physically possible.'} ` : 'The difference in BIC is given for either being the true one; the smaller of the two counts. ', 'Right of the dashed line (20 to 1) the wrong one is excluded.'),
    r.decides ? null : h('div', { class: 'notice' }, h('p', {}, 'This motion does not separate them. Record more periods, search longer, or allow a start at rest anywhere; otherwise the two differ by less than the noise.')),
    chart,
    h('details', {}, h('summary', {}, 'As a table'), table([{ head: 'Data', cell: (t) => t[1] }, ...cases.map(([key, cause]) => ({ head: `If it is ${on(cause)}`, term: 'rival_evidence', number: true, cell: ([k]) => `${number(of(k)[key], 3)}: ${odds(of(k)[key])}` }))], stages, { caption: 'Expected difference in BIC, with the odds' })),
    goingOn(result));
}

/** From a trajectory that was designed after an identification to the next one. */
function goingOn(result) {
  const after = earlier(result);
  const steps = [h('li', {}, h('a', { href: '#downloads' }, 'Download it'), ` and run it, ${result.request.periods > 1 ? `${result.request.periods} periods` : 'several periods'} in a row.`),
    h('li', {}, `Identify from the new log and the earlier one together${after ? ': the page names the file that it needs again' : ''}.`),
    h('li', {}, 'See in “Diagnosis” which of the two remains, and with what odds.')];
  return h('div', {}, h('h3', {}, 'How to go on'), h('ol', {}, steps), h('div', { class: 'actions' }, identifyLink(result, true)));
}

/** Every criterion, whichever was made small. */
function criteria(result) {
  const c = result.criteria;
  const advice = result.recommended_criterion;
  const rows = Object.entries(CRITERIA).filter(([key]) => c[key] !== null && c[key] !== undefined).map(([key, about]) => ({ key, ...about, value: c[key] }));
  const mark = (key) => [c.minimised === key ? h('span', { class: 'tag live' }, key === 'rival_evidence' ? 'maximised' : 'minimised') : null, ' ', advice?.criterion === key ? h('span', { class: 'tag good', title: advice.reason }, 'recommended') : null];
  return section('criteria', [term('criterion', 'Criteria')], h('p', { class: 'soft' }, 'Improving one criterion can worsen another. To compare, design again with another criterion and open the comparison at the end of this page.'),
    table([{ head: 'Criterion', cell: (r) => h('strong', {}, term(r.key, r.name)) }, { head: 'Value', number: true, cell: (r) => number(r.value, r.digits) }, { head: 'Role', hidden: true, cell: (r) => mark(r.key) }, { head: 'Meaning', cell: (r) => h('span', { class: 'soft meaning' }, r.meaning) }], rows, { caption: 'Of this trajectory' }),
    advice ? h('p', { class: 'soft' }, said(`Recommended: ${title(advice.criterion)}. ${sentence(inWords(advice.reason))}`)) : null);
}

function clearances(result, played) {
  if (!result.clearances?.length) return null;
  return section('clearances', [term('clearance', 'Clearances')], table([
    { head: 'Link of', cell: (c) => c.joint, sort: (c) => c.joint }, { head: 'From', cell: (c) => c.from, sort: (c) => c.from }, { head: 'Least distance', term: 'clearance', number: true, cell: (c) => `${number(c.least, 3)} m`, sort: (c) => c.least },
    { head: 'Proven above', number: true, cell: (c) => `${number(c.certified, 3)} m`, sort: (c) => c.certified, term: 'proven' },
    { head: 'Required', number: true, cell: (c) => `${number(c.asked, 3)} m`, sort: (c) => c.asked }, { head: 'At', number: true, cell: (c) => `${number(c.at_s)} s`, sort: (c) => c.at_s }, { head: 'Show', hidden: true, cell: (c) => h('button', { type: 'button', class: 'link', 'aria-label': `Show ${c.joint} and ${c.from}`, onclick: () => played.goTo(c) }, 'Show') },
    { head: 'Let them touch', hidden: true, cell: (c) => mayTouch(result, c) },
  ], result.clearances, { caption: 'Between links, and from obstacles', sort: { column: 2, way: 'ascending' } }));
}

/** For two links that come near without harm, such as a cable tray and the link below it: the form leaves the pair out next time. */
function mayTouch(result, { joint, from }) {
  if (!result.joints.includes(from)) return null;
  const pair = [joint, from];
  return h('button', { type: 'button', class: 'link', 'aria-label': `Let ${joint} and ${from} touch in the next design`, onclick: () => document.dispatchEvent(new CustomEvent('may-touch', { detail: pair })) }, 'Let them touch');
}

function margins(result) {
  const kinds = ['position', 'velocity', 'acceleration', 'jerk', 'torque'].filter((k) => result.margins.some((m) => m.quantity === k));
  const chart = place('Used share of every limit, per joint');
  plotLater(chart, () => ({
    traces: kinds.map((kind, i) => {
      const used = result.joints.map((joint) => Math.max(...result.margins.filter((m) => m.joint === joint && m.quantity === kind).map((m) => 100 * (1 - m.margin)), 0));
      return { type: 'bar', name: kind, x: result.joints, y: used, marker: { color: colour(i), pattern: { shape: ['', '/', 'x', '.', '-'][i] } }, hovertemplate: `%{y:.1f} % of the ${kind} limit<extra></extra>` };
    }),
    layout: { barmode: 'group', height: 280, yaxis: { title: 'limit used (%)', range: [0, 108] }, xaxis: { title: 'joint', type: 'category' }, hovermode: 'closest',
      shapes: [{ type: 'line', xref: 'paper', x0: 0, x1: 1, y0: 100, y1: 100, line: { dash: 'dash', width: 1.5, color: colour(6) } }] },
  }));
  return section('margins', 'Joint limits', chart, h('details', {}, h('summary', {}, 'As a table'), table([
    { head: 'Joint', cell: (m) => m.joint, sort: (m) => m.joint }, { head: 'Limit', cell: (m) => `${m.quantity}, ${m.side}`, sort: (m) => m.quantity },
    { head: 'Allowed', number: true, cell: (m) => `${number(m.limit)} ${unit(m.unit)}`, sort: (m) => m.limit }, { head: 'Reached', number: true, cell: (m) => number(m.peak), sort: (m) => m.peak },
    { head: 'Proven below', number: true, cell: (m) => number(m.certified_peak), sort: (m) => m.certified_peak, term: 'proven' },
    { head: 'At', number: true, cell: (m) => `${number(m.at_s)} s`, sort: (m) => m.at_s }, { head: 'Left', term: 'limit_margin', number: true, cell: (m) => `${number(100 * m.margin, 3)} %`, sort: (m) => m.margin },
  ], result.margins, { caption: 'Margins to both sides of every limit', sort: { column: 6, way: 'ascending' } })));
}

/** Units of the base parameters, where the robot has a name; a robot inside a request has no address to ask. */
async function units(result) {
  if (typeof result.request.robot !== 'string') return new Map();
  const base = await getJson(`/robots/${encodeURIComponent(result.request.robot)}/base-parameters`).catch(() => ({ base_parameters: [] }));
  return new Map(base.base_parameters.map((p) => [p.name, p]));
}

function accuracy(result, known) {
  const { std_dev: deviations, relative_std_dev_percent: relative, torque_noise: noise } = result.predicted;
  const rows = result.base_parameters.map((name, i) => ({ name, deviation: deviations[i], relative: relative?.[i], unit: unit(known.get(name)?.unit), expression: known.get(name)?.expression }));
  const chart = place('Predicted standard deviation of every base parameter');
  const shown = relative ? rows.filter((r) => r.relative !== null && r.relative !== undefined) : rows;
  plotLater(chart, () => ({
    traces: [{ type: 'bar', x: shown.map((r) => r.name), y: shown.map((r) => (relative ? r.relative : r.deviation)), marker: { color: colour(0) }, hovertemplate: `%{x}: %{y:.3g}${relative ? ' %' : ''}<extra></extra>` }],
    layout: { height: 300, hovermode: 'closest', xaxis: { tickangle: -90, tickfont: { size: 10 }, type: 'category', title: 'base parameter' },
      yaxis: { type: 'log', title: relative ? 'deviation over value (%)' : 'standard deviation (unit of each)' } },
  }));
  return section('accuracy', [term('std_dev', 'Predicted accuracy'), ' of the parameters'],
    h('p', { class: 'soft' }, `Standard deviations from one period, with torque noise of ${noise.map((n) => number(n, 3)).join(', ')} N·m (N for prismatic joints). ${relative ? 'Relative to the values known beforehand.' : ''} Ten periods make them smaller by √10.`),
    chart, h('details', {}, h('summary', {}, 'As a table'), table([
      { head: 'Parameter', term: 'base_parameters', cell: (r) => h('span', { title: r.expression }, r.name), sort: (r) => r.name },
      { head: 'Standard deviation', term: 'std_dev', number: true, cell: (r) => `${number(r.deviation, 3)} ${r.unit}`, sort: (r) => r.deviation },
      { head: 'Of its value', term: 'relative_std_dev', number: true, cell: (r) => (r.relative === null || r.relative === undefined ? '–' : `${number(r.relative, 3)} %`), sort: (r) => r.relative },
    ], rows, { caption: 'Predicted standard deviations' })), effectAccuracy(result));
}

/** Of the effects in the model that the design was made for. */
function effectAccuracy(result) {
  const rows = (result.effects ?? []).flatMap((e) => e.parameters.map((p) => ({ effect: words(on(e)), ...p })));
  return rows.length ? table([
    { head: 'Effect', term: 'effect', cell: (r) => r.effect }, { head: 'Parameter', cell: (r) => words(r.name) }, { head: 'Value so far', number: true, cell: (r) => `${number(r.value)} ${unit(r.unit === '1' ? '' : r.unit)}` },
    { head: 'Standard deviation', term: 'std_dev', number: true, cell: (r) => number(r.std_dev, 2) },
  ], rows, { caption: result.rivals ? 'Effects of the model, and the rival in the place of the finding' : 'Effects of the model, with their accuracy after the next log' }) : null;
}

function spectrum(result, drawn) {
  const chart = place('Amplitude of every harmonic of every joint');
  plotLater(chart, () => ({
    traces: result.joints.map((joint, j) => ({
      type: 'bar', name: joint, x: result.coefficients.a[j].map((_, l) => (l + 1) * result.fundamental_hz), y: result.coefficients.a[j].map((a, l) => Math.hypot(a, result.coefficients.b[j][l])),
      marker: { color: colour(j), pattern: { shape: ['', '/', '\\', 'x', '-', '|', '.'][j % 7] } }, hovertemplate: `${joint}: %{y:.3g} ${perSecond(drawn.joints[j].position_unit, 1)}<extra></extra>`,
    })),
    layout: { barmode: 'group', height: 300, hovermode: 'closest', xaxis: { title: 'frequency (Hz)', tickvals: result.coefficients.a[0].map((_, l) => (l + 1) * result.fundamental_hz) }, yaxis: { title: `velocity amplitude (${velocityUnits(drawn)})` } },
  }));
  return section('spectrum', 'Spectrum', chart);
}

const velocityUnits = (drawn) => [...new Set(drawn.joints.map((j) => perSecond(j.position_unit, 1)))].join(' or ');

function coefficients(result, drawn) {
  const rows = result.joints.flatMap((joint, j) => result.coefficients.a[j].map((a, l) => ({ joint, l: l + 1, a, b: result.coefficients.b[j][l], unit: perSecond(drawn.joints[j].position_unit, 1) })));
  return section('coefficients', 'Coefficients', h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Form of the motion' }, fourierSeries(number(result.fundamental_hz))),
    h('p', { class: 'soft' }, `q₀: ${result.offset.map((o, j) => `${result.joints[j]} ${number(o)} ${drawn.joints[j].position_unit}`).join(', ')}`),
    h('details', {}, h('summary', {}, 'As a table'), table([
      { head: 'Joint', cell: (r) => r.joint, sort: (r) => r.joint }, { head: 'l', term: 'harmonics', number: true, cell: (r) => r.l, sort: (r) => r.l },
      { head: 'a', term: 'fourier_coefficients', number: true, cell: (r) => `${number(r.a, 6)} ${r.unit}`, sort: (r) => r.a }, { head: 'b', term: 'fourier_coefficients', number: true, cell: (r) => `${number(r.b, 6)} ${r.unit}`, sort: (r) => r.b },
    ], rows, { caption: 'Fourier coefficients: amplitudes of velocity' })));
}

function starts(result) {
  const chart = place('Every random start: the criterion over the evaluations, one line per start');
  const shown = result.starts.filter((s) => s.course?.length > 1);
  if (shown.length) plotLater(chart, () => courses(shown.map((s) => s.course), result.criteria.minimised));
  return section('starts', 'Search', h('p', { class: 'soft' }, `${result.starts.length} random starts, ${result.search.rounds} round${result.search.rounds > 1 ? "s" : ""} of local searches; later rounds search around the best of them and give the final value.`), shown.length ? chart : null);
}
