// Where the frames of an arm are, and what is near to what.
export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const times = (m, v) => m.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
export const product = (a, b) => a.map((row) => [0, 1, 2].map((c) => row[0] * b[0][c] + row[1] * b[1][c] + row[2] * b[2][c]));
export const transposed = (m) => [0, 1, 2].map((c) => m.map((row) => row[c]));
export const UNIT = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

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

/** Against gravity, as unit vector in the base frame; z where nothing pulls. Whole numbers stay whole. */
export function upwards(gravity) {
  const size = Math.hypot(...gravity);
  return size < 1e-9 ? [0, 0, 1] : gravity.map((g) => Number((-g / size).toFixed(6)) + 0);
}

/** The robot's own size (m): how far its joints are apart, and what prismatic joints add. */
export function reach(joints) {
  const parts = joints.map((j) => Math.hypot(...j.translation) + (j.kind === 'prismatic' && j.position_limits ? j.position_limits[1] - j.position_limits[0] : 0));
  return Math.max(parts.reduce((a, b) => a + b, 0), 0.3);
}

export const three = (v) => Array.isArray(v) && v.length === 3 && v.every(Number.isFinite);
export const plane = ({ normal, offset }) => three(normal) && Math.hypot(...normal) > 0 && Number.isFinite(offset);

/** Half-axes squared of the solid ellipsoid with mass m and inertia I about its centre: I = m/5 (tr S · 1 − S). */
export function ellipsoid(mass, inertia) {
  const second = (inertia[0][0] + inertia[1][1] + inertia[2][2]) / 2;
  return inertia.map((row, r) => row.map((v, c) => (5 / mass) * ((r === c ? second : 0) - v)));
}

/** Nearest points of the segments (a, b) and (c, d). */
export function nearest([a, b], [c, d]) {
  const minus = (p, q) => p.map((v, i) => v - q[i]);
  const dot = (p, q) => p.reduce((sum, v, i) => sum + v * q[i], 0);
  const inside = (v) => Math.min(1, Math.max(0, v));
  const along = (p, q, share) => p.map((v, i) => v + share * (q[i] - v));
  const [u, v, w] = [minus(b, a), minus(d, c), minus(a, c)];
  const [uu, vv, uv, uw, vw] = [dot(u, u), dot(v, v), dot(u, v), dot(u, w), dot(v, w)];
  const area = uu * vv - uv * uv;
  let s = area > 1e-12 * uu * vv ? inside((uv * vw - vv * uw) / area) : 0;
  let t = vv > 0 ? (uv * s + vw) / vv : 0;
  if (t < 0 || t > 1) {
    t = inside(t);
    s = uu > 0 ? inside((uv * t - uw) / uu) : 0;
  }
  return [along(a, b, s), along(c, d, t)];
}

/** Where link `joint` comes nearest to link or obstacle `from` (names, as the interface reports them) at positions `q`: two points on the surfaces, or null. */
export function approach({ joints, q, shape, space }, { joint, from }) {
  const frames = poses(joints, q);
  const carried = (name) => shape.filter((c) => joints[c.joint].name === name).map((c) => ({ radius: c.radius, ends: [c.from, c.to].map((p) => add(frames[c.joint].position, times(frames[c.joint].rotation, p))) }));
  const others = [...carried(from).map((o) => (own) => [...nearest(own.ends, o.ends), o.radius]), ...(space?.half_spaces ?? []).filter((o) => o.name === from).map((o) => (own) => [...toPlane(own.ends, o), 0]), ...(space?.boxes ?? []).filter((o) => o.name === from).map((o) => (own) => [...toBox(own.ends, o), 0])];
  const pairs = carried(joint).flatMap((own) => others.map((to) => { const [a, b, radius] = to(own); return { a, b, radii: [own.radius, radius], gap: Math.hypot(...a.map((v, i) => v - b[i])) - own.radius - radius }; }));
  const best = pairs.sort((x, y) => x.gap - y.gap)[0];
  if (!best) return null;
  const long = Math.hypot(...best.a.map((v, i) => v - best.b[i])) || 1;
  const towards = (p, to, by) => p.map((v, i) => v + ((to[i] - v) * by) / long);
  return [towards(best.a, best.b, best.radii[0]), towards(best.b, best.a, best.radii[1])];
}

function toPlane(ends, { normal, offset }) {
  const size = Math.hypot(...normal);
  const height = (p) => p.reduce((sum, v, i) => sum + (v * normal[i]) / size, 0) - offset / size;
  const low = height(ends[0]) < height(ends[1]) ? ends[0] : ends[1];
  return [low, low.map((v, i) => v - (height(low) * normal[i]) / size)];
}

/** Along the segment in steps: exact enough to be seen. */
function toBox([a, b], { center, size }) {
  const at = Array.from({ length: 101 }, (_, k) => a.map((v, i) => v + ((b[i] - v) * k) / 100));
  const inside = (p) => p.map((v, i) => Math.min(center[i] + size[i] / 2, Math.max(center[i] - size[i] / 2, v)));
  const gap = (p) => Math.hypot(...inside(p).map((v, i) => v - p[i]));
  const best = at.reduce((least, p) => (gap(p) < gap(least) ? p : least));
  return [best, inside(best)];
}
