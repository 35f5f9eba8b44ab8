// The result of a design.
import { download, getJson, postJson } from './api.js';
import { compareWith } from './compare.js';
import { fill, figure, h, number, perSecond, seconds, table, unit, words } from './dom.js';
import { motionPlots } from './motion-plots.js';
import { player } from './player.js';
import { colour, plotLater } from './plot.js';

const STATUS = {
  Converged: ['good', 'The search found nothing better for a while: this is as good as it gets, or nearly.'],
  BudgetExhausted: ['', 'The time was over while it was still getting better: more time gives a lower number.'],
  Stalled: ['warn', 'The search got stuck early.'],
  Cancelled: ['warn', 'Stopped early; this is the best that was found. It keeps every limit.'],
  Infeasible: ['bad', 'No motion of this kind is possible.'],
};

const section = (id, title, ...parts) => h('section', { class: 'card', id, 'aria-labelledby': `${id}-title` }, h('h2', { id: `${id}-title` }, title), parts);
const place = (label, flat) => h('div', { class: `plot${flat ? ' flat' : ''}`, 'data-label': label });

export async function showDesign(target, result) {
  if (!result.coefficients) {
    fill(target, section('summary', 'No trajectory', h('div', { class: 'problem' }, h('strong', {}, words(result.status)), h('p', {}, result.reason))), notes(result));
    return;
  }
  const trajectory = { fundamental_hz: result.fundamental_hz, coefficients: result.coefficients, offset: result.offset };
  const drawn = await postJson('/motion', { robot: result.request.robot, trajectory, samples: 1001 });
  const parts = [
    ['summary', 'Summary'], ['motion', 'Motion'], ['path', 'Path'], ['margins', 'Margins'], ['accuracy', 'Accuracy'], ['spectrum', 'Spectrum'], ['coefficients', 'Coefficients'], ['starts', 'Search'], ['compare', 'Compare'],
  ];
  fill(target, h('nav', { class: 'toc', 'aria-label': 'Parts of the result' }, parts.map(([id, name]) => h('a', { href: `#${id}` }, name))),
    summary(result), notes(result), motionPlots(drawn), player(drawn), margins(result), accuracy(result, await units(result)), spectrum(result, drawn), coefficients(result, drawn), starts(result), compareWith(result));
}

function notes(result) {
  return result.notes.length ? h('div', { class: 'notice' }, result.notes.map((n) => h('p', {}, n))) : null;
}

function summary(result) {
  const [kind, meaning] = STATUS[result.status] ?? ['', ''];
  const c = result.criteria;
  const tightest = [...result.margins].sort((a, b) => a.margin - b.margin)[0];
  const used = result.search;
  return section('summary', result.robot,
    h('p', {}, h('span', { class: `tag ${kind}` }, words(result.status)), ' ', meaning),
    h('dl', { class: 'figures' }, figure('Condition number', number(c.condition_number)), figure('I-optimality', number(c.i_optimality), 'N·m per unit of noise'),
      figure('D-optimality', number(c.d_optimality, 3)), figure('A-optimality', number(c.a_optimality, 3)), figure('Period', number(result.period_s), 's'),
      tightest ? figure('Tightest limit', `${number(100 * tightest.margin, 2)} %`, `left: ${tightest.joint}, ${tightest.quantity}`) : null),
    h('p', { class: 'soft' }, `${result.order} harmonics, ${used.evaluations.toLocaleString()} evaluations in ${seconds(used.elapsed_s)}, seed ${used.seed}. Minimised: ${words(c.minimised).toLowerCase()}.`),
    downloads(result));
}

function downloads(result) {
  const rate = h('input', { type: 'number', class: 'narrow', value: 1000, min: 1, 'aria-label': 'Samples per second of the download', style: 'width:6.5rem' });
  const periods = h('input', { type: 'number', class: 'narrow', value: 1, min: 1, 'aria-label': 'Periods in the download', style: 'width:4.5rem' });
  const links = h('span', { class: 'row' });
  const build = () => fill(links, ['csv', 'json'].map((format) =>
    download(format.toUpperCase(), `/excitation/${result.id}/trajectory?format=${format}&rate_hz=${rate.value}&periods=${periods.value}`, `trajectory-${result.id}.${format}`)),
  download('Result with request (JSON)', `/excitation/${result.id}`, `design-${result.id}.json`));
  rate.addEventListener('input', build);
  periods.addEventListener('input', build);
  build();
  return h('div', { id: 'downloads' }, h('h3', {}, 'Download for the controller'), h('div', { class: 'row' }, rate, 'samples per second,', periods, 'periods', links),
    h('p', { class: 'help' }, 'Columns time, q, qd, qdd (s; rad or m). Run it several periods in a row: their repetition is what measures the noise later.'),
    h('p', {}, h('a', { class: 'button', href: `/identification?excitation=${result.id}${typeof result.request.robot === 'string' ? `&robot=${encodeURIComponent(result.request.robot)}` : ''}` }, 'I have run it: identify')));
}

function margins(result) {
  const kinds = ['position', 'velocity', 'acceleration', 'jerk', 'torque'].filter((k) => result.margins.some((m) => m.quantity === k));
  const chart = place('Share of every limit that the motion uses, per joint');
  plotLater(chart, () => ({
    traces: kinds.map((kind, i) => {
      const used = result.joints.map((joint) => Math.max(...result.margins.filter((m) => m.joint === joint && m.quantity === kind).map((m) => 100 * (1 - m.margin)), 0));
      return { type: 'bar', name: kind, x: result.joints, y: used, marker: { color: colour(i), pattern: { shape: ['', '/', 'x', '.', '-'][i] } }, hovertemplate: `%{y:.1f} % of the ${kind} limit<extra></extra>` };
    }),
    layout: { barmode: 'group', height: 280, yaxis: { title: 'used of the limit (%)', range: [0, 108] }, xaxis: { title: 'joint', type: 'category' }, hovermode: 'closest',
      shapes: [{ type: 'line', xref: 'paper', x0: 0, x1: 1, y0: 100, y1: 100, line: { dash: 'dash', width: 1.5, color: colour(6) } }] },
  }));
  return section('margins', 'How far every limit is', chart, h('details', {}, h('summary', {}, 'As a table'), table([
    { head: 'Joint', cell: (m) => m.joint, sort: (m) => m.joint }, { head: 'Limit', cell: (m) => `${m.quantity}, ${m.side}`, sort: (m) => m.quantity },
    { head: 'Allowed', number: true, cell: (m) => `${number(m.limit)} ${unit(m.unit)}`, sort: (m) => m.limit }, { head: 'Reached', number: true, cell: (m) => number(m.peak), sort: (m) => m.peak },
    { head: 'Proven below', number: true, cell: (m) => number(m.certified_peak), sort: (m) => m.certified_peak, title: 'Bound on the extreme over all time, between the samples too' },
    { head: 'At', number: true, cell: (m) => `${number(m.at_s)} s`, sort: (m) => m.at_s }, { head: 'Left', number: true, cell: (m) => `${number(100 * m.margin, 3)} %`, sort: (m) => m.margin },
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
  return section('accuracy', 'How accurately each parameter will come out',
    h('p', { class: 'soft' }, `Standard deviations from one period, with torque noise of ${noise.map((n) => number(n, 3)).join(', ')} N·m (N for sliding joints). ${relative ? 'Relative to the values known beforehand.' : ''} Ten periods make them smaller by √10.`),
    chart, h('details', {}, h('summary', {}, 'As a table'), table([
      { head: 'Parameter', cell: (r) => h('span', { title: r.expression }, r.name), sort: (r) => r.name },
      { head: 'Standard deviation', number: true, cell: (r) => `${number(r.deviation, 3)} ${r.unit}`, sort: (r) => r.deviation },
      { head: 'Of its value', number: true, cell: (r) => (r.relative === null || r.relative === undefined ? '–' : `${number(r.relative, 3)} %`), sort: (r) => r.relative },
    ], rows, { caption: 'Predicted standard deviations' })));
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
  const formula = h('p', { class: 'expression' }, h('i', {}, 'q'), '(t) = q', h('sub', {}, '0'), ' + Σ', h('sub', {}, 'l'), ' a', h('sub', {}, 'l'), '/(ωl) sin(ωlt) − b', h('sub', {}, 'l'), '/(ωl) cos(ωlt),  ω = 2π · ', number(result.fundamental_hz), ' Hz');
  return section('coefficients', 'Coefficients', formula,
    h('p', { class: 'soft' }, `q₀: ${result.offset.map((o, j) => `${result.joints[j]} ${number(o)} ${drawn.joints[j].position_unit}`).join(', ')}`),
    h('details', {}, h('summary', {}, 'As a table'), table([
      { head: 'Joint', cell: (r) => r.joint, sort: (r) => r.joint }, { head: 'l', number: true, cell: (r) => r.l, sort: (r) => r.l },
      { head: 'a', number: true, cell: (r) => `${number(r.a, 6)} ${r.unit}`, sort: (r) => r.a }, { head: 'b', number: true, cell: (r) => `${number(r.b, 6)} ${r.unit}`, sort: (r) => r.b },
    ], rows, { caption: 'Fourier coefficients: amplitudes of velocity' })));
}

function starts(result) {
  const chart = place('Every random start: where it began and what its local search reached');
  const shown = result.starts.filter((s) => s.reached !== null).sort((a, b) => a.reached - b.reached);
  plotLater(chart, () => ({
    traces: [
      { type: 'scatter', mode: 'lines', x: shown.flatMap((_, i) => [i + 1, i + 1, null]), y: shown.flatMap((s) => [s.initial ?? s.reached, s.reached, null]), line: { color: colour(5), width: 1 }, hoverinfo: 'skip', showlegend: false },
      { type: 'scatter', mode: 'markers', name: 'began', x: shown.map((_, i) => i + 1), y: shown.map((s) => s.initial), marker: { color: colour(1), symbol: 'circle-open', size: 6 } },
      { type: 'scatter', mode: 'markers', name: 'reached', x: shown.map((_, i) => i + 1), y: shown.map((s) => s.reached), marker: { color: colour(0), size: 6 } },
    ],
    layout: { height: 280, xaxis: { title: 'random start, best first', rangemode: 'tozero' }, yaxis: { type: 'log', title: words(result.criteria.minimised).toLowerCase() } },
  }));
  return section('starts', 'How the search went', h('p', { class: 'soft' }, `${result.starts.length} random starts in ${result.search.rounds} rounds; later rounds search around the best of them, which is where the final value comes from.`), shown.length ? chart : null);
}
