// The arm where a motion starts, among the obstacles that it avoids: seen while the form is filled in.
import { ArmView, HOW_TO_TURN, poses, upwards } from './arm.js';
import { getJson, postJson } from './api.js';
import { h } from './dom.js';

const turned = (t, v) => [0, 1, 2].map((c) => t[0][c] * v[0] + t[1][c] * v[1] + t[2][c] * v[2]);

/** The arm's own shape from its description: capsules {joint, from, to, radius} in the frames of its joints; none if it has none. */
export async function shapeOf(robot, joints) {
  const description = typeof robot === 'string' ? await getJson(`/robots/${encodeURIComponent(robot)}`).catch(() => null) : robot;
  return (description?.joints ?? []).flatMap((joint, j) => (joint.geometry ?? []).map((capsule) => {
    const [from, to] = ['from', 'to'].map((end) => turned(joints[j].description_frame, capsule[end]));
    return { joint: j, from, to, radius: capsule.radius };
  }));
}

/** Where motions start that say nothing else: zero, or the middle of the range where zero is outside it. */
export function startOf(joints, start) {
  return joints.map((joint, j) => {
    if (Number.isFinite(start?.[j])) return start[j];
    const [low, high] = joint.position_limits ?? [-1, 1];
    return low <= 0 && high >= 0 ? 0 : (low + high) / 2;
  });
}

/** Arms in their zero position end at half their reach and above, or stretched out at a tenth of it. */
const LOW = 0.25;

export class CellView {
  constructor() {
    this.holder = h('div');
    this.element = h('figure', { class: 'cell' }, this.holder, h('figcaption', { class: 'help' }, 'Where the motion starts. Grid 0.25 m, through the origin of the base frame. ', HOW_TO_TURN));
  }

  /** What is known of `robot`, asked for once. */
  async load(robot) {
    const key = JSON.stringify(robot);
    if (this.key === key) return this.known;
    this.key = key;
    this.known = (async () => {
      const drawn = await postJson('/motion', { robot });
      return drawn;
    })();
    return this.known;
  }

  async show(robot, space, start) {
    const known = await this.load(robot).catch(() => null);
    if (!known || JSON.stringify(robot) !== this.key) return;
    if (this.drawn !== known) {
      this.drawn = known;
      const canvas = h('canvas', { class: 'arm low', 'aria-label': 'The arm where the motion starts, with the floor, walls and boxes. Arrow keys turn the view.' });
      this.holder.replaceChildren(canvas);
      this.view = new ArmView(canvas, known.joints, known.gravity);
    }
    const { view } = this;
    Object.assign(view, { space, shape: known.shape, q: startOf(known.joints, start) });
    view.frameCell();
    view.draw();
  }

  /** How high a floor may stand, at most at the origin, for the arm to start `clearance` above it: {normal, offset}, in steps of 5 cm. */
  async floor(robot, clearance, start) {
    const { joints, gravity, shape } = await this.load(robot);
    const normal = upwards(gravity);
    const frames = poses(joints, startOf(joints, start));
    const height = (p) => p[0] * normal[0] + p[1] * normal[1] + p[2] * normal[2];
    const ends = shape.flatMap(({ joint, from, to, radius }) => [from, to].map((p) => {
      const { rotation, position } = frames[joint];
      return height(rotation.map((row, i) => row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + position[i])) - radius;
    }));
    const least = Math.min(...ends, clearance + 1) - clearance;
    return { normal, offset: least > 0 ? 0 : Number((Math.ceil(least / 0.05 - 1) * 0.05).toFixed(2)) };
  }

  /**
   * Whether the arm starts stretched out just above a plane, from where hardly any motion leads: its end is lower than `LOW` of its
   * reach.
   */
  async startsLow(robot, { normal, offset }, start) {
    const { joints } = await this.load(robot);
    const ends = poses(joints, startOf(joints, start)).map((frame) => frame.position);
    const end = ends.at(-1);
    return end[0] * normal[0] + end[1] * normal[1] + end[2] * normal[2] - offset < LOW * Math.max(...ends.map((p) => Math.hypot(...p)));
  }
}
