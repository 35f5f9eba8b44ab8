// q, qd, qdd and expected torque over one period, against the limits.
import { h, mark, perSecond, unit } from './dom.js';
import { colour, dash, plot, plotLater, variable } from './plot.js';

const QUANTITIES = [
  { key: 'q', name: 'position', limit: (j) => j.position_limits, unit: (j) => j.position_unit },
  { key: 'qd', name: 'velocity', limit: (j) => both(j.velocity_limit), unit: (j) => perSecond(j.position_unit, 1) },
  { key: 'qdd', name: 'acceleration', limit: (j) => both(j.acceleration_limit), unit: (j) => perSecond(j.position_unit, 2) },
  { key: 'torque', name: 'expected torque', limit: (j) => both(j.effort_limit), unit: (j) => unit(j.effort_unit) },
];
const both = (limit) => (limit === null || limit === undefined ? null : [-limit, limit]);

export function motionPlots({ joints, motion }) {
  const chart = h('div', { class: 'plot', 'data-label': 'Position, velocity, acceleration and expected torque over one period' });
  const limited = joints.some((joint) => QUANTITIES.some((quantity) => motion[quantity.key] && quantity.limit(joint)));
  const choice = h('select', { class: 'narrow', id: 'motion-joint' }, limited ? h('option', { value: 'share' }, 'all joints, as share of their limits') : null, h('option', { value: 'all' }, 'all joints, in their units'), ...joints.map((j, i) => h('option', { value: i }, j.name)));
  const shown = QUANTITIES.filter((q) => motion[q.key]);
  const make = () => (choice.value === 'all' ? overview(joints, motion, shown) : choice.value === 'share' ? shares(joints, motion, shown) : single(joints[choice.value], Number(choice.value), motion, shown));
  choice.addEventListener('change', () => plot(chart, make));
  plotLater(chart, make);
  const without = motion.torque ? null : h('p', { class: 'soft' }, 'No expected torque: the robot has no prior link parameters. A URDF file with inertials, or an identified model, brings them.');
  return h('section', { class: 'card', id: 'motion', 'aria-labelledby': 'motion-title' },
    h('div', { class: 'row spread' }, h('h2', { id: 'motion-title' }, 'Motion against its limits'), h('span', { class: 'labelled' }, h('label', { class: 'inline', for: 'motion-joint' }, 'Show', choice), mark('limit_share', 'Share of a limit'))), without, chart);
}

/** Stacked axes with one time axis: zooming one zooms all. */
function frame(count) {
  const gap = 0.06;
  const each = (1 - gap * (count - 1)) / count;
  const axis = (i) => `yaxis${i ? i + 1 : ''}`;
  const layout = { height: 170 * count + 60, xaxis: { title: 'time (s)', anchor: `y${count > 1 ? count : ''}` } };
  for (let i = 0; i < count; i += 1) {
    const top = 1 - i * (each + gap);
    layout[axis(i)] = { domain: [Math.max(top - each, 0), top] };
  }
  return { layout, axis };
}

/** All joints against their limits at once: the limits are at ±100 %, for positions from the middle of the range. */
function shares(joints, motion, quantities) {
  const limited = quantities.filter((quantity) => joints.some((joint) => quantity.limit(joint)));
  const { layout, axis } = frame(limited.length);
  const share = (quantity, joint, j) => {
    const limit = quantity.limit(joint);
    if (!limit) return null;
    const [middle, half] = [(limit[0] + limit[1]) / 2, (limit[1] - limit[0]) / 2];
    return motion[quantity.key][j].map((v) => (100 * (v - middle)) / half);
  };
  const traces = limited.flatMap((quantity, i) => joints.map((joint, j) => ({
    type: 'scatter', mode: 'lines', name: joint.name, legendgroup: joint.name, showlegend: i === 0, x: motion.time, y: share(quantity, joint, j) ?? motion.time.map(() => null), yaxis: `y${i ? i + 1 : ''}`,
    line: { color: colour(j), dash: dash(j), width: 1.8 }, hovertemplate: '%{y:.0f} %',
  })));
  const bad = variable('--bad');
  const shapes = limited.flatMap((_, i) => [-100, 100].map((at) => ({ type: 'line', xref: 'paper', x0: 0, x1: 1, yref: `y${i ? i + 1 : ''}`, y0: at, y1: at, line: { color: bad, dash: 'dash', width: 1.5 } })));
  limited.forEach((quantity, i) => Object.assign(layout[axis(i)], { title: `${quantity.name}<br>(% of limit)`, range: [-112, 112] }));
  return { traces, layout: { ...layout, shapes } };
}

/** All joints in their own units; limits are in the plots of single joints. */
function overview(joints, motion, quantities) {
  const { layout, axis } = frame(quantities.length);
  const traces = quantities.flatMap((quantity, i) => joints.map((joint, j) => ({
    type: 'scatter', mode: 'lines', name: joint.name, legendgroup: joint.name, showlegend: i === 0, x: motion.time, y: motion[quantity.key][j], yaxis: `y${i ? i + 1 : ''}`,
    line: { color: colour(j), dash: dash(j), width: 1.8 }, hovertemplate: `%{y:.3g} ${quantity.unit(joint)}`,
  })));
  quantities.forEach((quantity, i) => {
    layout[axis(i)].title = `${quantity.name}<br>(${[...new Set(joints.map(quantity.unit))].join(' or ')})`;
  });
  return { traces, layout };
}

function single(joint, index, motion, quantities) {
  const { layout, axis } = frame(quantities.length);
  const bad = variable('--bad');
  const shapes = [];
  const traces = quantities.map((quantity, i) => {
    const limit = quantity.limit(joint);
    const reference = `y${i ? i + 1 : ''}`;
    limit?.forEach((at) => shapes.push({ type: 'line', xref: 'paper', x0: 0, x1: 1, yref: reference, y0: at, y1: at, line: { color: bad, dash: 'dash', width: 1.5 } }));
    layout[axis(i)].title = `${quantity.name}<br>(${quantity.unit(joint)})`;
    if (limit) layout[axis(i)].range = widened(limit);
    return { type: 'scatter', mode: 'lines', name: quantity.name, x: motion.time, y: motion[quantity.key][index], yaxis: reference, line: { color: colour(index), width: 2 }, showlegend: false };
  });
  traces.push({ type: 'scatter', mode: 'lines', x: [null], y: [null], name: 'limit', line: { color: bad, dash: 'dash', width: 1.5 } });
  return { traces, layout: { ...layout, shapes } };
}

const widened = ([low, high]) => [low - 0.06 * (high - low), high + 0.06 * (high - low)];
