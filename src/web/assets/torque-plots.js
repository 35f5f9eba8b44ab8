// Measured and predicted torque on top of each other, the residual below, one joint at a time.
import { fill, h, mark, number, sinceStart } from './dom.js';
import { colour, gaps, plotLong, variable } from './plot.js';

export const MODELS = { base: 'identified model (base parameters)', physical: 'identified model (physical parameters)', declared: 'declared model, without the effects' };

/** `first`: number of the joint to begin with. */
export function torquePlots(result, effort, { models: called = MODELS, first = 0 } = {}) {
  const card = h('section', { class: 'card', id: 'torques', 'aria-labelledby': 'torques-title' }, h('h2', { id: 'torques-title' }, 'Measured and predicted torque'));
  const series = result.predictions;
  if (!series.length) {
    card.append(h('p', { class: 'soft' }, result.predictions_error ?? 'This run kept no series to draw: its request set prediction_points to 0 or left it out.'));
    return card;
  }
  const logs = [...new Set(series.map((s) => s.log))];
  const models = Object.keys(called).filter((m) => series[0][m] && (m !== 'declared' || result.residual?.findings.length));
  const log = h('select', { class: 'narrow', id: 'torque-log' }, logs.map((l) => h('option', {}, l)));
  const joint = h('select', { class: 'narrow', id: 'torque-joint' }, result.joints.map((j, i) => h('option', { selected: i === first }, j)));
  const model = h('select', { class: 'narrow', id: 'torque-model' }, models.map((m) => h('option', { value: m }, called[m])));
  const chart = h('div', { class: 'plot', style: 'min-height:26rem', 'data-label': 'Measured and predicted torque over time, and their difference' });
  const text = h('p', { class: 'soft', 'aria-live': 'polite' });
  const draw = () => {
    const one = series.find((s) => s.log === log.value && s.joint === joint.value);
    // The first drawing counts from the answer of the interface.
    const started = (card.dataset.drawnMs ? null : performance.getEntriesByName('answered').at(-1)?.startTime) ?? performance.now();
    // A fresh place: what listened to the old plot goes with it.
    const place = chart.cloneNode(false);
    fill(holder, place);
    const time = sinceStart(one.time);
    const residual = one.measured.map((m, i) => m - one[model.value][i]);
    const rms = Math.sqrt(residual.reduce((sum, r) => sum + r * r, 0) / residual.length);
    const unit = effort[result.joints.indexOf(joint.value)];
    text.textContent = `RMS difference of the points drawn: ${number(rms, 3)} ${unit}. ${innerWidth < 640 ? 'The buttons above the plot zoom.' : 'Drag over the plot to zoom, double-click to go back.'}${gaps(time).length ? ' Gaps are rows that the fit leaves out, where the joint hardly moves.' : ''}`;
    plotLong(place, [
      { x: time, y: one.measured, trace: () => ({ name: 'measured', line: { color: variable('--soft'), width: 2.4 } }) },
      { x: time, y: one[model.value], trace: () => ({ name: 'predicted', line: { color: colour(1), width: 1.3 } }) },
      { x: time, y: residual, trace: () => ({ name: 'measured − predicted', yaxis: 'y2', line: { color: colour(0), width: 1 } }) },
    ], () => ({ height: 430, yaxis: { domain: [0.4, 1], title: `torque (${unit})` }, yaxis2: { domain: [0, 0.33], title: `difference<br>(${unit})` }, xaxis: { title: 'time (s)', anchor: 'y2' } }))
      .then(() => requestAnimationFrame(() => requestAnimationFrame(() => {
        // For measurements: how long drawing took, and when it was on the screen after the page was asked for.
        Object.assign(card.dataset, { drawnMs: Math.round(performance.now() - started), drawnAt: Math.round(performance.now()) });
      })));
  };
  const holder = h('div');
  [log, joint, model].forEach((c) => c.addEventListener('change', draw));
  card.append(h('div', { class: 'row' }, h('label', { class: 'inline' }, 'Log', log), h('label', { class: 'inline' }, 'Joint', joint), h('span', { class: 'labelled' }, h('label', { class: 'inline' }, 'Predicted by', model), mark('model_kind', 'Model that predicts'))), holder, text);
  queueMicrotask(draw);
  return card;
}
