// The residual against the variable that explains it: before and after.
import { fill, h, perSecond, sentence, sinceStart, term } from './dom.js';
import { colour, isDark, plot, variable } from './plot.js';

export function residualPlot(context) {
  const { result, report } = context;
  const card = h('section', { class: 'card', id: 'dependence', 'aria-labelledby': 'dependence-title' }, h('h2', { id: 'dependence-title' }, [term('residual_over', 'Residual over the variable'), ' that explains it']));
  const series = result.predictions;
  if (!series.length || !series[0].declared) {
    card.append(h('p', { class: 'soft' }, result.predictions_error ?? 'This run kept no series to draw: its request set prediction_points to 0 or left it out.'));
    return card;
  }
  const [first] = suggestions(result, report);
  const log = select('Log', [...new Set(series.map((s) => s.log))]);
  const joint = select('Joint', result.joints, first.joint ?? result.joints[0]);
  const across = select('Over', variables(result), first.variable);
  const along = select('and', ['nothing else', ...variables(result)], first.second ?? 'nothing else');
  const holder = h('div');
  const about = h('p', { class: 'soft' });
  const draw = () => {
    const place = h('div', { class: 'plot', 'data-label': 'Residual before and after against a variable' });
    fill(holder, place);
    const data = collect(context, series, log.value, joint.value, across.value, along.value);
    const [one, other] = narrow() ? ['Above', 'below'] : ['Left', 'right'];
    about.textContent = data.second
      ? `${one}, as colour, the residual of the declared model; ${other} ${inModel(context) ? 'what the effects found add to its prediction. The same pattern, less the noise, is theirs.' : 'the same with the effects found.'}`
      : `${one}: residual of the declared model; the small dots are what the effects found add to its prediction. ${sentence(other).slice(0, -1)}: residual with the effects found.`;
    plot(place, () => (data.second ? map(context, data) : scatter(context, data)));
  };
  [log, joint, across, along].forEach((c) => c.addEventListener('change', draw));
  card.append(about, h('div', { class: 'row' }, [log, joint, across, along].map((c) => c.parentElement)), holder);
  queueMicrotask(draw);
  return card;
}

const narrow = () => innerWidth < 640;
const inModel = (context) => context.report.findings.some((f) => f.in_model);

function select(name, options, chosen) {
  const field = h('select', { class: 'narrow' }, options.map((o) => h('option', { selected: o === chosen }, o)));
  h('label', { class: 'inline' }, name, field);
  return field;
}

const variables = (result) => ['time', ...['q', 'qd', 'qdd', 'tau'].flatMap((k) => result.joints.map((j) => `${k} ${j}`))];

/** What to show first: the first finding, else the remainder, else the joint with the greatest lack of fit over time. */
function suggestions(result, report) {
  const named = (text) => {
    const [, kind, number] = /^(q|qd|qdd|load)(\d+)$/.exec(text) ?? [];
    return kind ? `${kind === 'load' ? 'tau' : kind} ${result.joints[number - 1]}` : 'time';
  };
  const r = report.remainder;
  const most = r ? r.joints[r.rms.indexOf(Math.max(...r.rms))] : null;
  const left = r ? [{ joint: most, variable: named(r.depends_on[0] ?? ''), second: r.depends_on[1] ? named(r.depends_on[1]) : undefined }] : [];
  const over = ({ law, joints, against: { joint, variable } }) => {
    if (!law?.variables.length) return { joint, variable: variable === 'time' ? 'time' : `${variable} ${joint}` };
    const [first, second] = law.variables.map(named);
    return { joint: joints[0], variable: first, second };
  };
  const found = report.findings.filter((f) => f.against?.joint).map(over);
  const worst = [...report.lack_of_fit].sort((a, b) => b.statistic - a.statistic)[0];
  return [...found, ...left, { joint: worst?.joint ?? result.joints[0], variable: 'time' }];
}

/** Linear interpolation of (x, y) at `at`, both ascending. */
function interpolated(x, y, at) {
  let k = 0;
  return at.map((t) => {
    while (k + 2 < x.length && x[k + 1] < t) k += 1;
    const share = (t - x[k]) / (x[k + 1] - x[k] || 1);
    return y[k] + Math.min(1, Math.max(0, share)) * (y[k + 1] - y[k]);
  });
}

function collect(context, series, log, joint, across, along) {
  const one = series.find((s) => s.log === log && s.joint === joint);
  const of = (name) => {
    if (name === 'time') return sinceStart(one.time);
    const [kind, other] = [name.slice(0, name.indexOf(' ')), name.slice(name.indexOf(' ') + 1)];
    const source = series.find((s) => s.log === log && s.joint === other);
    const values = kind === 'tau' ? source.measured : source[kind];
    return other === joint ? values : interpolated(source.time, values, one.time);
  };
  // As many as an eye can tell apart: evenly taken, peaks and all.
  const step = Math.max(1, Math.floor(one.time.length / 2500));
  const picked = (list) => list.filter((_, i) => i % step === 0);
  const rest = (model) => picked(one.measured.map((m, i) => m - model[i]));
  const added = picked(one.base.map((b, i) => b - one.declared[i]));
  return { joint, across, along, added, x: picked(of(across)), second: along === 'nothing else' ? null : picked(of(along)), before: rest(one.declared), after: rest(one.base) };
}

function title(context, name) {
  if (name === 'time') return 'time (s)';
  const at = name.indexOf(' ');
  const [kind, j] = [name.slice(0, at), context.result.joints.indexOf(name.slice(at + 1))];
  const units = { q: perSecond(context.position[j], 0), qd: perSecond(context.position[j], 1), qdd: perSecond(context.position[j], 2), tau: context.effort[j] };
  return `${name} (${units[kind]})`;
}

function scatter(context, { joint, across, x, before, after, added }) {
  const unit = context.effort[context.result.joints.indexOf(joint)];
  const dots = (name, y, axis, tone) => ({ type: 'scatter', mode: 'markers', name, x, y, xaxis: axis ? 'x2' : 'x', yaxis: axis ? 'y2' : 'y', marker: { color: tone, size: 3.5, opacity: 0.55 }, hovertemplate: '%{x:.3g}, %{y:.3g}<extra></extra>' });
  const widest = 1.08 * Math.max(...before.map(Math.abs), ...after.map(Math.abs));
  const layout = narrow()
    ? { xaxis: { title: title(context, across), anchor: 'y2' }, xaxis2: { matches: 'x', anchor: 'y2', title: title(context, across) }, yaxis: { domain: [0.56, 1], range: [-widest, widest], title: `without<br>effects (${unit})` }, yaxis2: { domain: [0, 0.44], range: [-widest, widest], title: `with<br>effects (${unit})` }, height: 480 }
    : { xaxis: { title: title(context, across), domain: [0, 0.47] }, xaxis2: { title: title(context, across), domain: [0.53, 1], matches: 'x', anchor: 'y2' }, yaxis: { range: [-widest, widest], title: `residual (${unit})` }, yaxis2: { matches: 'y', anchor: 'x2', showticklabels: true }, height: 360 };
  const effects = { ...dots('what the effects add', added, 0, variable('--ink')), marker: { color: variable('--ink'), size: 2.5 } };
  const shown = inModel(context) ? [effects] : [];
  return { traces: [dots('declared model', before, 0, colour(1)), ...shown, dots('with the effects found', after, 1, colour(0))], layout: { ...layout, legend: { itemsizing: 'constant' }, hovermode: 'closest' } };
}

/** Over two variables, as colour: the residual, and what the effects add to the prediction, as far as it reaches. Blue and brown, distinguishable by all. */
function map(context, { joint, across, along, x, second, before, after, added }) {
  const unit = context.effort[context.result.joints.indexOf(joint)];
  const largest = (values) => Math.max(...values.map(Math.abs));
  const [shown, name] = inModel(context) && largest(added) > 0 ? [added, 'what the effects add'] : [after, 'with the effects found'];
  const widest = shown === added ? 1.5 * largest(added) : largest(before);
  const colorscale = [[0, '#00857a'], [0.5, isDark() ? '#59626c' : '#cfd5db'], [1, '#c96a00']];
  const dots = (values, axis) => ({ type: 'scatter', mode: 'markers', x, y: second, xaxis: `x${axis}`, yaxis: `y${axis}`, text: values.map((v) => v.toPrecision(3)), hovertemplate: `%{text} ${unit}<extra></extra>`, showlegend: false,
    marker: { size: 6, color: values, cmin: -widest, cmax: widest, colorscale, ...(axis ? {} : { colorbar: { title: { text: `torque<br>(${unit})` }, thickness: 12 } }) } });
  const titles = { xaxis: title(context, across), yaxis: title(context, along) };
  const heading = (text, at) => ({ text, xref: 'paper', yref: 'paper', showarrow: false, xanchor: 'left', yanchor: 'bottom', ...at });
  const layout = narrow()
    ? { height: 540, xaxis: { title: titles.xaxis, anchor: 'y' }, yaxis: { domain: [0.57, 0.95], title: titles.yaxis }, xaxis2: { title: titles.xaxis, matches: 'x', anchor: 'y2' }, yaxis2: { domain: [0, 0.38], title: titles.yaxis, matches: 'y' },
      annotations: [heading('declared model', { x: 0, y: 0.955 }), heading(name, { x: 0, y: 0.385 })] }
    : { height: 420, margin: { l: 64, r: 18, t: 30, b: 44 }, xaxis: { title: titles.xaxis, domain: [0, 0.47] }, yaxis: { title: titles.yaxis }, xaxis2: { title: titles.xaxis, domain: [0.53, 1], matches: 'x', anchor: 'y2' }, yaxis2: { matches: 'y', anchor: 'x2', showticklabels: true },
      annotations: [heading('declared model', { x: 0, y: 1.01 }), heading(name, { x: 0.53, y: 1.01 })] };
  return { traces: [dots(before, ''), dots(shown, '2')], layout: { ...layout, hovermode: 'closest' } };
}
