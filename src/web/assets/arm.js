// A robot arm in space, drawn by three.js without perspective: to be turned, moved and zoomed with mouse, fingers and keys.
import { add, plane, poses, reach, three as triple, times, transposed, UNIT } from './arm-geometry.js';
import { parts } from './arm-parts.js';
import { colour, variable } from './plot.js';

export { ellipsoid, poses, upwards } from './arm-geometry.js';

let loading = null;
/** three.js and what draws with it, made once for all views of a page. */
function drawing() {
  loading ??= import('/assets/three.js').then((three) => ({ three, paint: painter(three) }));
  return loading;
}

/** Draws a scene into the canvas of a view: with WebGL, or as a vector picture where a browser has none. */
function painter(three) {
  try {
    const renderer = new three.WebGLRenderer({ antialias: true, alpha: true });
    return (scene, camera, canvas) => {
      renderer.setSize(canvas.width, canvas.height, false);
      renderer.render(scene, camera);
      const context = canvas.getContext('2d');
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.drawImage(renderer.domElement, 0, 0);
    };
  } catch {
    const renderer = new three.SVGRenderer();
    return (scene, camera, canvas) => {
      renderer.setSize(canvas.width, canvas.height);
      renderer.render(scene, camera);
      renderer.domElement.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
      const picture = new Image();
      picture.onload = () => {
        const context = canvas.getContext('2d');
        context.clearRect(0, 0, canvas.width, canvas.height);
        context.drawImage(picture, 0, 0);
      };
      picture.src = `data:image/svg+xml,${encodeURIComponent(new XMLSerializer().serializeToString(renderer.domElement))}`;
    };
  }
}

const KEYS = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };

/** `path`: points; `space`: what the arm avoids; `shape`: capsules; `bodies`: ellipsoids; `near`: two points; `limits`: whether ranges of joints are drawn. */
export class ArmView {
  constructor(canvas, joints, gravity = [0, 0, -9.81]) {
    Object.assign(this, { canvas, path: null, space: null, shape: [], bodies: [], meshes: [], near: null, limits: false, azimuth: -0.9, elevation: 0.35, zoom: 1, moved: [0, 0, 0] });
    this.replace(joints, gravity);
    this.listen();
    new ResizeObserver(() => this.draw()).observe(canvas);
    document.addEventListener('theme', () => this.draw());
  }

  /** Shows another arm from the same side. */
  replace(joints, gravity) {
    Object.assign(this, { joints, q: joints.map(() => 0), reach: reach(joints), made: null, pulled: Math.hypot(...gravity) > 1e-9 });
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
    const sides = this.sides([[0, 0, 0], ...all.flatMap((q) => poses(this.joints, q).map((f) => f.position))]);
    this.centre = sides.map(([low, high]) => (low + high) / 2);
    const [x, y, z] = sides.map(([low, high]) => high - low);
    // The canvas is wide: depth and width share it, height needs its own.
    this.span = 1.25 * Math.max(z + 0.35 * Math.hypot(x, y), 0.6 * Math.hypot(x, y), 0.5 * this.reach);
  }

  /** Looks at the arm as it stands, and at the boxes and planes around it. */
  frameCell() {
    const frames = poses(this.joints, this.q);
    const ends = this.shape.flatMap(({ joint, from, to }) => [from, to].map((p) => add(frames[joint].position, times(frames[joint].rotation, p))));
    const boxes = (this.space?.boxes ?? []).filter((b) => [b.center, b.size].every(triple)).flatMap(({ center, size }) => [-0.5, 0.5].map((side) => center.map((c, i) => c + side * size[i])));
    const planes = (this.space?.half_spaces ?? []).filter(plane).map(({ normal, offset }) => normal.map((c) => (c * offset) / Math.hypot(...normal)));
    const sides = this.sides([[0, 0, 0], ...frames.map((f) => f.position), ...ends, ...boxes, ...planes]);
    this.centre = sides.map(([low, high]) => (low + high) / 2);
    this.span = Math.max(Math.hypot(...sides.map(([low, high]) => high - low)), this.reach);
  }

  /** Ranges of points of the base frame in the upright frame. */
  sides(points) {
    const turned = points.map((p) => times(this.up, p));
    return [0, 1, 2].map((i) => [Math.min(...turned.map((p) => p[i])), Math.max(...turned.map((p) => p[i]))]);
  }

  set(q) {
    this.q = q;
    if (this.made) this.made.pose(q);
    this.render();
  }

  listen() {
    const { canvas } = this;
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'img');
    canvas.addEventListener('keydown', (e) => {
      if (KEYS[e.key]) this.turn(...KEYS[e.key]);
      else if (['+', '-'].includes(e.key)) this.magnify(e.key === '+' ? 1.2 : 1 / 1.2);
      else if (e.key === '0') this.reset();
      else return;
      e.preventDefault();
    });
    // Scrolling the page over a picture does not zoom it; once it is chosen, the wheel is its own.
    canvas.addEventListener('wheel', (e) => {
      if (document.activeElement !== canvas) return;
      e.preventDefault();
      this.magnify(Math.exp(-0.0015 * e.deltaY));
    }, { passive: false });
    canvas.addEventListener('contextmenu', (e) => e.preventDefault());
    this.fingers();
  }

  /** One finger or the left button turns, two fingers zoom and move, the right button moves. */
  fingers() {
    const { canvas } = this;
    const down = new Map();
    const middle = () => [0, 1].map((i) => [...down.values()].reduce((sum, p) => sum + p[i], 0) / down.size);
    const apart = () => { const [a, b] = [...down.values()]; return b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 0; };
    canvas.addEventListener('pointerdown', (e) => { down.set(e.pointerId, [e.clientX, e.clientY]); canvas.setPointerCapture(e.pointerId); canvas.focus({ preventScroll: true }); });
    for (const name of ['pointerup', 'pointercancel', 'lostpointercapture']) canvas.addEventListener(name, (e) => down.delete(e.pointerId));
    canvas.addEventListener('pointermove', (e) => {
      if (!down.has(e.pointerId)) return;
      const [before, wide] = [middle(), apart()];
      down.set(e.pointerId, [e.clientX, e.clientY]);
      const [dx, dy] = middle().map((v, i) => v - before[i]);
      if (down.size > 1 && wide > 0) this.magnify(apart() / wide);
      if (down.size > 1 || e.buttons === 2 || e.shiftKey) this.shift(dx, dy);
      else this.turn(dx * 0.01, dy * 0.01);
    });
  }

  turn(azimuth, elevation) {
    this.azimuth -= azimuth;
    this.elevation = Math.min(1.55, Math.max(-1.55, this.elevation + elevation));
    this.render();
  }

  magnify(factor) {
    this.zoom = Math.min(20, Math.max(0.2, this.zoom * factor));
    this.render();
  }

  /** By pixels on the screen. */
  shift(dx, dy) {
    const metres = this.span / this.zoom / Math.min(this.canvas.clientWidth, this.canvas.clientHeight);
    const [right, up] = this.screen();
    this.moved = this.moved.map((v, i) => v - metres * (dx * right[i] - dy * up[i]));
    this.render();
  }

  reset() {
    Object.assign(this, { azimuth: -0.9, elevation: 0.35, zoom: 1, moved: [0, 0, 0] });
    this.render();
  }

  /** Right, up and towards the viewer, in the upright frame. */
  screen() {
    const [ca, sa, ce, se] = [Math.cos(this.azimuth), Math.sin(this.azimuth), Math.cos(this.elevation), Math.sin(this.elevation)];
    return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
  }

  /** Everything anew: after another arm, other things around it, or another theme. */
  draw() {
    this.made = null;
    this.render();
  }

  render() {
    if (this.asked) return;
    this.asked = requestAnimationFrame(() => {
      this.asked = null;
      this.paint();
    });
  }

  async paint() {
    const { canvas } = this;
    const { three, paint } = await drawing();
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width || !height) return;
    const sharp = Math.min(window.devicePixelRatio || 1, 2);
    if (canvas.width !== Math.round(width * sharp)) canvas.width = Math.round(width * sharp);
    if (canvas.height !== Math.round(height * sharp)) canvas.height = Math.round(height * sharp);
    this.made ??= parts(three, this, { colour, variable });
    this.made.pose(this.q);
    paint(this.made.scene, this.camera(three, width, height), canvas);
    Object.assign(canvas.dataset, { drawn: 'true', meshes: this.meshes.length });
  }

  camera(three, width, height) {
    const half = this.span / this.zoom / 2 / Math.min(width, height);
    const far = 40 * (this.span + this.reach);
    const camera = new three.OrthographicCamera(-half * width, half * width, half * height, -half * height, 0.01, 2 * far);
    const at = this.centre.map((c, i) => c + this.moved[i]);
    camera.up.set(0, 0, 1);
    camera.position.set(...at.map((c, i) => c + far * this.screen()[2][i]));
    camera.lookAt(...at);
    this.made.light.position.copy(camera.position).add(new three.Vector3(...this.screen()[1]).multiplyScalar(0.6 * far));
    camera.updateMatrixWorld();
    return camera;
  }
}

export const HOW_TO_TURN = 'Drag to turn; click, then use the wheel or + and − to zoom (two fingers on a phone); drag with the right button to move; 0 goes back.';
