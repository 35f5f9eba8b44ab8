// Two designs side by side.
import { explain, getJson } from './api.js';
import { reached } from './criteria.js';
import { fill, h, number, table, time, words } from './dom.js';
import { colour, plot } from './plot.js';

export function compareWith(result) {
  const choice = h('select', { class: 'narrow', id: 'other', style: 'max-width:100%' }, h('option', { value: '' }, 'choose a design'));
  const place = h('div');
  getJson('/jobs').then(({ jobs }) => {
    const others = jobs.filter((j) => j.kind === 'excitation' && j.id !== result.id && ['finished', 'cancelled'].includes(j.state));
    choice.append(...others.map((j) => h('option', { value: j.id }, `${time(j.finished_at)}: ${j.progress?.best ? reached(j.progress) : words(j.outcome)}`)));
    if (!others.length) fill(place, h('p', { class: 'soft' }, 'There is no other design yet.'));
  }).catch((e) => explain(place, e));
  choice.addEventListener('change', async () => {
    if (!choice.value) return fill(place);
    try {
      show(place, result, await getJson(`/excitation/${choice.value}`));
    } catch (error) {
      explain(place, error);
    }
  });
  return h('section', { class: 'card', id: 'compare', 'aria-labelledby': 'compare-title' }, h('h2', { id: 'compare-title' }, 'Compare with another design'), h('label', { class: 'inline', for: 'other' }, 'With', choice), place);
}

function show(place, one, other) {
  if (!other.criteria) return fill(place, h('p', {}, 'That one ended without a trajectory.'));
  const tightest = (r) => Math.min(...r.margins.map((m) => m.margin));
  const lines = [
    ['Robot', (r) => r.robot], ['Condition number', (r) => number(r.criteria.condition_number)], ['Scaled condition number', (r) => number(r.criteria.scaled_condition_number)],
    ['I-optimality', (r) => number(r.criteria.i_optimality)], ['D-optimality', (r) => number(r.criteria.d_optimality)], ['A-optimality', (r) => number(r.criteria.a_optimality)],
    ['Period', (r) => `${number(r.period_s)} s`], ['Harmonics', (r) => r.order], ['Limits', (r) => r.request.constraints?.form ?? 'paper'], ['Start', (r) => r.request.constraints?.start ?? 'zero'],
    ['Tightest limit', (r) => `${number(100 * tightest(r), 3)} % left`],
  ];
  const chart = h('div', { class: 'plot', 'data-label': 'Ratio of the predicted deviations of the two designs, per base parameter' });
  fill(place, table([{ head: 'Property', hidden: true, cell: (l) => l[0] }, { head: 'This one', number: true, cell: (l) => l[1](one) }, { head: 'The other', number: true, cell: (l) => l[1](other) }], lines, { caption: 'The two designs' }));
  const shared = one.base_parameters.map((name, i) => [name, i, other.base_parameters.indexOf(name)]).filter(([, i, k]) => k >= 0 && one.predicted.std_dev[i] && other.predicted.std_dev[k]);
  if (!shared.length || one.robot !== other.robot) return place.append(h('p', { class: 'soft' }, 'Deviations of different robots are not compared.'));
  place.append(h('h3', {}, 'Predicted deviation: this one over the other'), h('p', { class: 'help' }, 'Below 1 this design determines the parameter better.'), chart);
  const scale = (r, i) => r.predicted.std_dev[i];
  if (String(one.predicted.torque_noise) !== String(other.predicted.torque_noise)) place.append(h('p', { class: 'notice' }, 'The two assume different torque noise, which is part of the ratio.'));
  return plot(chart, () => ({
    traces: [{ type: 'bar', x: shared.map((s) => s[0]), y: shared.map(([, i, k]) => scale(one, i) / scale(other, k)), base: 0, marker: { color: shared.map(([, i, k]) => (scale(one, i) <= scale(other, k) ? colour(2) : colour(1))) }, hovertemplate: '%{x}: %{y:.3g}<extra></extra>' }],
    layout: { height: 300, hovermode: 'closest', xaxis: { tickangle: -90, tickfont: { size: 10 }, type: 'category', title: 'base parameter' }, yaxis: { title: 'ratio of deviations' }, shapes: [{ type: 'line', xref: 'paper', x0: 0, x1: 1, y0: 1, y1: 1, line: { width: 1.5, dash: 'dash', color: colour(6) } }] },
  }));
}
