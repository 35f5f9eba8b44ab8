// The arm playing a motion, with the path of its last frame.
import { ArmView, HOW_TO_TURN } from './arm.js';
import { approach } from './arm-geometry.js';
import { h, number } from './dom.js';

/** `space`: what the arm avoids, as in the request; `shape`: the capsules that it does so with. */
export function player({ joints, gravity, motion }, space, { shape = [], clearances = [], meshes = Promise.resolve([]) } = {}) {
  const canvas = h('canvas', { class: 'arm', 'aria-label': 'The arm in its motion, with the path of its last frame. Arrow keys turn the view.' });
  const last = motion.time.length - 1;
  const slider = h('input', { type: 'range', min: 0, max: last, value: 0, 'aria-label': 'Time in the period' });
  const button = h('button', { type: 'button', 'aria-pressed': 'false' }, '▶ Play');
  const clock = h('output', { class: 'number', style: 'min-width:9rem' });
  const view = new ArmView(canvas, joints, gravity);
  view.path = motion.end;
  view.space = space;
  view.shape = shape;
  meshes.then((list) => { view.meshes = list; view.draw(); });
  view.frameArm(motion.time.flatMap((_, s) => (s % 20 ? [] : [motion.q.map((q) => q[s])])));
  if (space) view.span *= 1.25;
  const show = (sample) => {
    slider.value = sample;
    clock.textContent = `${motion.time[sample].toFixed(2)} s of ${number(motion.time[last])} s`;
    view.set(motion.q.map((q) => q[sample]));
  };
  let begun = null;
  const step = (now) => {
    if (begun === null || !canvas.isConnected) return;
    // The time of a frame may be before that of the click that began it.
    const at = (Math.max(now - begun, 0) / 1000) % motion.time[last];
    show(Math.round((at / motion.time[last]) * last));
    requestAnimationFrame(step);
  };
  button.addEventListener('click', () => {
    const playing = begun === null;
    begun = playing ? performance.now() - 1000 * motion.time[slider.value] : null;
    button.textContent = playing ? '❚❚ Pause' : '▶ Play';
    button.setAttribute('aria-pressed', String(playing));
    if (playing) requestAnimationFrame(step);
  });
  slider.addEventListener('input', () => {
    if (begun !== null) begun = performance.now() - 1000 * motion.time[slider.value];
    show(Number(slider.value));
  });
  show(0);
  const nearest = (c) => nearestSample(motion.time, c.at_s);
  const closest = [...clearances].sort((a, b) => a.least - a.asked - (b.least - b.asked))[0];
  const mark = (c) => { view.near = approach({ joints, q: motion.q.map((q) => q[nearest(c)]), shape, space }, c); view.draw(); };
  if (closest) mark(closest);
  const goTo = closest ? h('button', { type: 'button', onclick: () => element.goTo(closest) }, 'Show the closest approach') : null;
  const box = ['x', 'y', 'z'].map((name, i) => {
    // What is zero but for rounding is zero.
    const values = motion.end.map((p) => (Math.abs(p[i]) < 1e-9 ? 0 : p[i]));
    return `${name} ${number(Math.min(...values), 3)} … ${number(Math.max(...values), 3)} m`;
  });
  const element = h('section', { class: 'card', id: 'path', 'aria-labelledby': 'path-title' }, h('h2', { id: 'path-title' }, 'Path of the last frame'), canvas,
    h('div', { class: 'row', style: 'margin-top:.6rem' }, button, goTo, h('span', { style: 'flex:1;min-width:8rem' }, slider), clock),
    h('p', { class: 'help' }, `In real time. The grid is 0.25 m; the path keeps within ${box.join(', ')} in the base frame. ${space ? 'Floor, walls and boxes of the request are drawn, and the shape of the arm that keeps clear of them; a red line marks the closest approach.' : 'Check it against your cell: the request named no floor and no obstacles.'} ${HOW_TO_TURN}`));
  /** Stops where a link is nearest to what it avoids; a red line joins the two. */
  element.goTo = (clearance) => {
    if (begun !== null) button.click();
    mark(clearance);
    show(nearest(clearance));
    canvas.scrollIntoView({ block: 'center' });
  };
  return element;
}

const nearestSample = (time, at) => time.reduce((best, t, i) => (Math.abs(t - at) < Math.abs(time[best] - at) ? i : best), 0);
