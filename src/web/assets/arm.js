// A robot arm on a canvas, seen without perspective: what is round stays round, and an ellipsoid is exactly an ellipse.
import { colour, variable } from './plot.js';

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const times = (m, v) => m.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
const product = (a, b) => a.map((row) => [0, 1, 2].map((c) => row[0] * b[0][c] + row[1] * b[1][c] + row[2] * b[2][c]));
const transposed = (m) => [0, 1, 2].map((c) => m.map((row) => row[c]));
const UNIT = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

/** Poses of all joint frames in the base frame at positions `q`; each joint turns about, or slides along, the z axis of its frame. */
export function poses(joints, q) {
  let at = { rotation: UNIT, position: [0, 0, 0] };
  return joints.map((joint, j) => {
    const rotation = product(at.rotation, joint.rotation);
    let position = add(at.position, times(at.rotation, joint.translation));
    if (joint.kind === 'prismatic') {
      position = add(position, rotation.map((row) => row[2] * q[j]));
      at = { rotation, position };
    } else {
      const [c, s] = [Math.cos(q[j]), Math.sin(q[j])];
      at = { rotation: product(rotation, [[c, -s, 0], [s, c, 0], [0, 0, 1]]), position };
    }
    return at;
  });
}

/** Principal axes of a symmetric 2 × 2 matrix: half lengths and the angle of the first. */
function ellipse([[a, b], [, d]]) {
  const [mean, spread] = [(a + d) / 2, Math.hypot((a - d) / 2, b)];
  return { long: Math.sqrt(Math.max(mean + spread, 0)), short: Math.sqrt(Math.max(mean - spread, 0)), angle: 0.5 * Math.atan2(2 * b, a - d) };
}

/** Against gravity, as unit vector in the base frame; z where nothing pulls. Whole numbers stay whole. */
export function upwards(gravity) {
  const size = Math.hypot(...gravity);
  return size < 1e-9 ? [0, 0, 1] : gravity.map((g) => Number((-g / size).toFixed(6)) + 0);
}

/** The robot's own size (m): how far its joints are apart, and what sliding joints add. */
function reach(joints) {
  const parts = joints.map((j) => Math.hypot(...j.translation) + (j.kind === 'prismatic' && j.position_limits ? j.position_limits[1] - j.position_limits[0] : 0));
  return Math.max(parts.reduce((a, b) => a + b, 0), 0.3);
}

const three = (v) => Array.isArray(v) && v.length === 3 && v.every(Number.isFinite);
const plane = ({ normal, offset }) => three(normal) && Math.hypot(...normal) > 0 && Number.isFinite(offset);

export class ArmView {
  constructor(canvas, joints, gravity = [0, 0, -9.81]) {
    Object.assign(this, { canvas, path: null, space: null, shape: [], bodies: [], azimuth: -0.9, elevation: 0.35 });
    this.replace(joints, gravity);
    this.listen();
    new ResizeObserver(() => this.draw()).observe(canvas);
    document.addEventListener('theme', () => this.draw());
  }

  /** Shows another arm from the same side. */
  replace(joints, gravity) {
    Object.assign(this, { joints, q: joints.map(() => 0), reach: reach(joints) });
    this.up = this.upright(gravity);
    // In the upright frame, as the ground is.
    const heights = [0, ...poses(joints, this.q).map((f) => times(this.up, f.position)[2])];
    this.centre = [0, 0, (Math.min(...heights) + Math.max(...heights)) / 2];
    this.span = 1.7 * this.reach;
  }

  /** Turns the base frame so that gravity points down on the screen. */
  upright(gravity) {
    const size = Math.hypot(...gravity);
    if (size < 1e-9) return UNIT;
    const z = gravity.map((g) => -g / size);
    const seed = Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1];
    const along = seed[0] * z[0] + seed[1] * z[1] + seed[2] * z[2];
    const raw = seed.map((s, i) => s - along * z[i]);
    const x = raw.map((r) => r / Math.hypot(...raw));
    return [x, [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]], z];
  }

  /** Looks at the arm where it is at the positions `all`, and as it stands. */
  frameArm(all = [this.q]) {
    const points = [[0, 0, 0], ...all.flatMap((q) => poses(this.joints, q).map((f) => f.position))].map((p) => times(this.up, p));
    const sides = [0, 1, 2].map((i) => [Math.min(...points.map((p) => p[i])), Math.max(...points.map((p) => p[i]))]);
    this.centre = sides.map(([low, high]) => (low + high) / 2);
    const [x, y, z] = sides.map(([low, high]) => high - low);
    // The canvas is wide: depth and width share it, height needs its own.
    this.span = 1.25 * Math.max(z + 0.35 * Math.hypot(x, y), 0.6 * Math.hypot(x, y), 0.5 * this.reach);
  }

  /** Looks at the arm as it stands, and at the boxes and planes around it. */
  frameCell() {
    const frames = poses(this.joints, this.q);
    const ends = this.shape.flatMap(({ joint, from, to }) => [from, to].map((p) => add(frames[joint].position, times(frames[joint].rotation, p))));
    const boxes = (this.space?.boxes ?? []).filter((b) => [b.center, b.size].every(three)).flatMap(({ center, size }) => [-0.5, 0.5].map((side) => center.map((c, i) => c + side * size[i])));
    const planes = (this.space?.half_spaces ?? []).filter(plane).map(({ normal, offset }) => normal.map((c) => (c * offset) / (Math.hypot(...normal) || 1)));
    const points = [[0, 0, 0], ...frames.map((f) => f.position), ...ends, ...boxes, ...planes].map((p) => times(this.up, p));
    const sides = [0, 1, 2].map((i) => [Math.min(...points.map((p) => p[i])), Math.max(...points.map((p) => p[i]))]);
    this.centre = sides.map(([low, high]) => (low + high) / 2);
    this.span = Math.max(Math.hypot(...sides.map(([low, high]) => high - low)), this.reach);
  }

  set(q) {
    this.q = q;
    this.draw();
  }

  listen() {
    let grip = null;
    this.canvas.addEventListener('pointerdown', (e) => { grip = [e.clientX, e.clientY]; this.canvas.setPointerCapture(e.pointerId); });
    this.canvas.addEventListener('pointerup', () => { grip = null; });
    this.canvas.addEventListener('pointercancel', () => { grip = null; });
    this.canvas.addEventListener('pointermove', (e) => {
      if (!grip) return;
      this.turn((e.clientX - grip[0]) * 0.01, (e.clientY - grip[1]) * 0.01);
      grip = [e.clientX, e.clientY];
    });
    this.canvas.addEventListener('keydown', (e) => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[e.key];
      if (!step) return;
      e.preventDefault();
      this.turn(...step);
    });
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('role', 'img');
  }

  turn(azimuth, elevation) {
    this.azimuth -= azimuth;
    this.elevation = Math.min(1.55, Math.max(-1.55, this.elevation + elevation));
    this.draw();
  }

  /** Rows: right, up, towards the viewer; in the base frame. */
  camera() {
    const [ca, sa, ce, se] = [Math.cos(this.azimuth), Math.sin(this.azimuth), Math.cos(this.elevation), Math.sin(this.elevation)];
    return product([[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]], this.up);
  }

  draw() {
    const { canvas } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    const sharp = Math.min(window.devicePixelRatio || 1, 2);
    if (canvas.width !== Math.round(width * sharp)) canvas.width = Math.round(width * sharp);
    if (canvas.height !== Math.round(height * sharp)) canvas.height = Math.round(height * sharp);
    const context = canvas.getContext('2d');
    context.setTransform(sharp, 0, 0, sharp, 0, 0);
    context.clearRect(0, 0, width, height);
    const camera = this.camera();
    const centre = times(transposed(this.up), this.centre);
    const scale = Math.min(width, height) / this.span;
    const project = (p) => {
      const v = times(camera, p.map((x, i) => x - centre[i]));
      return [width / 2 + scale * v[0], height / 2 - scale * v[1], v[2]];
    };
    Object.assign(this, { context, project, scale, view: camera });
    this.drawGround();
    const frames = poses(this.joints, this.q);
    const things = [...(this.path ? this.pathParts() : []), ...this.obstacles(), ...this.capsules(frames)];
    this.links(frames, things);
    for (const body of this.bodies) things.push(this.bodyPart(body, frames));
    things.sort((a, b) => a.depth - b.depth).forEach((thing) => thing.draw());
    this.drawAxes(frames.at(-1));
  }

  line(from, to, width, style, cap = 'round') {
    const { context } = this;
    context.strokeStyle = style;
    context.lineWidth = width;
    context.lineCap = cap;
    context.beginPath();
    context.moveTo(from[0], from[1]);
    context.lineTo(to[0], to[1]);
    context.stroke();
  }

  drawGround() {
    const turn = transposed(this.up);
    const half = Math.ceil(this.reach * 4) / 4;
    const at = (x, y) => this.project(times(turn, [x, y, 0]));
    for (let k = -half; k <= half + 1e-9; k += 0.25) {
      const style = variable('--line');
      this.line(at(k, -half), at(k, half), 1, style);
      this.line(at(-half, k), at(half, k), 1, style);
    }
  }

  links(frames, things) {
    const thick = this.scale * this.reach * 0.055;
    const points = [[0, 0, 0], ...frames.map((f) => f.position)];
    const push = (from, to, width, style, edge) => {
      const [a, b] = [this.project(from), this.project(to)];
      const draw = () => { this.line(a, b, width + 2, edge); this.line(a, b, width, style); };
      things.push({ depth: (a[2] + b[2]) / 2, draw });
    };
    const [body, edge] = [variable('--arm') || '#9aa7b4', variable('--ink')];
    for (let j = 0; j + 1 < points.length; j += 1) push(points[j], points[j + 1], thick * (1 - 0.06 * j), body, edge);
    frames.forEach((frame, j) => {
      const axis = frame.rotation.map((row) => row[2] * this.reach * 0.035);
      push(frame.position.map((p, i) => p - axis[i]), add(frame.position, axis), thick * 1.25 * (1 - 0.05 * j), colour(j), edge);
    });
  }

  pathParts() {
    const style = variable('--accent');
    const points = this.path.map(this.project);
    const parts = [];
    const step = Math.max(1, Math.floor(points.length / 400));
    for (let i = 0; i + step < points.length; i += step) {
      const [a, b] = [points[i], points[i + step]];
      parts.push({ depth: (a[2] + b[2]) / 2, draw: () => this.line(a, b, 1.6, style) });
    }
    return parts;
  }

  /** What the arm keeps off things with: without perspective a capsule is exactly a thick line with round ends. */
  capsules(frames) {
    return this.shape.map(({ joint, from, to, radius }) => {
      const [a, b] = [from, to].map((p) => this.project(add(frames[joint].position, times(frames[joint].rotation, p))));
      const draw = () => {
        this.context.globalAlpha = 0.22;
        this.line(a, [b[0] + 0.01, b[1]], 2 * radius * this.scale, variable('--soft'));
        this.context.globalAlpha = 1;
      };
      return { depth: (a[2] + b[2]) / 2 + radius, draw };
    });
  }

  /** Boxes, and a patch of every floor and wall: translucent faces with edges. */
  obstacles() {
    const face = (corners) => {
      const seen = corners.map(this.project);
      const draw = () => {
        const { context } = this;
        context.beginPath();
        seen.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
        context.closePath();
        context.globalAlpha = 0.16;
        context.fillStyle = variable('--warn');
        context.fill();
        context.globalAlpha = 0.8;
        context.strokeStyle = variable('--warn');
        context.lineWidth = 1.2;
        context.stroke();
        context.globalAlpha = 1;
      };
      return { depth: seen.reduce((sum, p) => sum + p[2], 0) / seen.length, draw };
    };
    const box = ({ center, size }) => [0, 1, 2].flatMap((axis) => [-0.5, 0.5].map((side) => {
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
      return face([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(([a, b]) => {
        const corner = [...center];
        corner[axis] += side * size[axis];
        corner[u] += a * size[u];
        corner[v] += b * size[v];
        return corner;
      }));
    }));
    const patch = ({ normal, offset }) => {
      const n = normal.map((c) => c / Math.hypot(...normal));
      const seed = Math.abs(n[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
      const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
      const across = cross(n, seed).map((c, _, all) => (c / Math.hypot(...all)) * this.reach);
      const along = cross(n, across);
      const at = (a, b) => n.map((c, i) => (c * offset) / Math.hypot(...normal) + a * across[i] + b * along[i]);
      return face([at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)]);
    };
    // While the form is filled in, numbers may be missing.
    return [...(this.space?.boxes ?? []).filter((b) => [b.center, b.size].every(three)).flatMap(box), ...(this.space?.half_spaces ?? []).filter(plane).map(patch)];
  }

  /** An ellipsoid {joint, centre, shape, label}: shape is its half-axes squared as a matrix, both in the frame of the joint. */
  bodyPart({ joint, centre, shape, label }, frames) {
    const frame = frames[joint];
    const place = this.project(add(frame.position, times(frame.rotation, centre)));
    const turn = product(this.view, frame.rotation);
    const seen = ellipse(product(product(turn, shape), transposed(turn)));
    const draw = () => {
      const { context } = this;
      context.save();
      context.beginPath();
      context.ellipse(place[0], place[1], Math.max(seen.long * this.scale, 2), Math.max(seen.short * this.scale, 2), -seen.angle, 0, 2 * Math.PI);
      context.globalAlpha = 0.35;
      context.fillStyle = colour(joint);
      context.fill();
      context.globalAlpha = 1;
      context.strokeStyle = colour(joint);
      context.lineWidth = 2;
      context.stroke();
      context.fillStyle = variable('--ink');
      context.font = '600 12px system-ui, sans-serif';
      context.textAlign = 'center';
      context.fillText(label, place[0], place[1] + 4);
      context.restore();
    };
    return { depth: place[2] + this.reach, draw };
  }

  drawAxes(frame) {
    const names = ['x', 'y', 'z'];
    const from = this.project(frame.position);
    this.context.font = '600 12px system-ui, sans-serif';
    names.forEach((name, i) => {
      const to = this.project(add(frame.position, frame.rotation.map((row) => row[i] * this.reach * 0.12)));
      this.line(from, to, 2.2, variable('--ink'));
      this.context.fillStyle = variable('--ink');
      this.context.fillText(name, to[0] + 3, to[1] - 3);
    });
  }
}

/** Half-axes squared of the solid ellipsoid with mass m and inertia I about its centre: I = m/5 (tr S · 1 − S). */
export function ellipsoid(mass, inertia) {
  const second = (inertia[0][0] + inertia[1][1] + inertia[2][2]) / 2;
  return inertia.map((row, r) => row.map((v, c) => (5 / mass) * ((r === c ? second : 0) - v)));
}
