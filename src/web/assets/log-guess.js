// Which column of a foreign log is what: by the words in its name and the number or joint at its end.

const QUANTITIES = [
  ['velocity', /(^|[^a-z])(qd|dq|qdot|qp|vel|velocity|velocities|speed|omega)([^a-z]|$)/],
  ['torque', /(^|[^a-z])(tau|tau_j|torque|torques|trq|moment|effort|efforts|current|currents|i)([^a-z]|$)|torque|trq|current/],
  ['position', /(^|[^a-z])(q|pos|position|positions|ang|angle|angles|theta|joint|axis|axisqmsr|a|j)([^a-z]|$)|jntpos|jointpos|qmsr|position/],
];
const TIME = /^(time|timestamp|stamp|clock|t|sec|secs|seconds|zeit|__time)([^a-z].*)?$|[_/. ]time(stamp)?$/;
/** Of several candidates the measured one; what was commanded says nothing of the robot. */
const RANKS = [[/actual|meas|msr|state/, 3], [/target|desired|des([^a-z]|$)|command|cmd|ref|setpoint|goal/, -5], [/ext|error|err([^a-z]|$)|std|temp|filtered|control/, -4], [/current|(^|[^a-z])i([^a-z]|$)/, -1]];

/** Programs whose logs are known by their column names. */
export const PRESETS = [
  ['Universal Robots RTDE', (names) => names.includes('actual_q_0')], ['Franka (libfranka)', (names) => names.some((n) => /tau_j(\[|_)?0/i.test(n))],
  ['KUKA FRI', (names) => names.some((n) => /axisqmsr|measuredjointposition|msrjntpos/i.test(n))], ['ROS joint_states', (names) => names.some((n) => /joint_states|\/log_time$/.test(n))],
];

/** {time, count, position: [names], velocity, torque, preset}: lists of one name per joint, or null where they were not found. */
export function guess(columns, joints) {
  const names = columns.filter((c) => c.numeric).map((c) => c.name);
  // Of a recording of messages the stamps of the senders come before the times of receipt.
  const time = names.find((n) => TIME.test(n.toLowerCase()) && !n.includes('/')) ?? names.find((n) => /\/stamp$/.test(n)) ?? names.find((n) => TIME.test(n.toLowerCase())) ?? null;
  const groups = new Map();
  for (const name of names.filter((n) => n !== time)) {
    const found = part(name, joints);
    if (!found) continue;
    const key = `${found.quantity} ${found.stem}`;
    if (!groups.has(key)) groups.set(key, { ...found, members: new Map() });
    groups.get(key).members.set(found.index, name);
  }
  // What a controller does not measure it often writes as zeros.
  const moves = new Set(columns.filter((c) => c.points.some((v) => v !== c.points[0])).map((c) => c.name));
  const best = (quantity) => {
    const whole = [...groups.values()].filter((g) => g.quantity === quantity).map((g) => ({ list: complete(g.members, joints.length), rank: rank(g.stem) })).filter((g) => g.list && (quantity !== 'velocity' || g.list.every((name) => moves.has(name))));
    return whole.sort((a, b) => b.rank - a.rank)[0]?.list ?? null;
  };
  // A log of another arm: as many positions as its names count.
  const counts = [...groups.values()].filter((g) => g.quantity === 'position').map((g) => g.members.size);
  return { time, count: Math.max(0, ...counts), position: best('position'), velocity: best('velocity'), torque: best('torque'), preset: PRESETS.find(([, is]) => is(names))?.[0] ?? null };
}

function part(name, joints) {
  const lower = name.toLowerCase();
  const named = joints.map((j, at) => ({ j: j.toLowerCase(), at })).filter(({ j }) => lower.includes(j) && (j.length > 2 || lower === j || lower.endsWith(`_${j}`) || lower.startsWith(`${j}_`))).sort((a, b) => b.j.length - a.j.length)[0];
  const number = /(\d+)\D*$/.exec(lower);
  if (!named && !number) return null;
  const stem = named ? lower.replace(named.j, ' ') : `${lower.slice(0, number.index)} ${lower.slice(number.index + number[1].length)}`;
  const quantity = QUANTITIES.find(([, words]) => words.test(stem))?.[0];
  return quantity ? { quantity, stem, index: named ? `joint ${named.at}` : Number(number[1]) } : null;
}

function complete(members, count) {
  for (const keys of [(j) => `joint ${j}`, (j) => j + 1, (j) => j]) {
    const list = Array.from({ length: count }, (_, j) => members.get(keys(j)));
    if (list.every(Boolean)) return list;
  }
  return null;
}

const rank = (stem) => RANKS.reduce((sum, [words, by]) => sum + (words.test(stem) ? by : 0), 0);

const largest = (columns) => columns.reduce((most, c) => Math.max(most, c.largest ?? 0), 0);

/** Units that names and sizes suggest; `kinds` of the joints. */
export function units(columns, found, kinds) {
  const of = (list) => columns.filter((c) => list?.includes(c.name));
  const says = (list, words) => (list ?? []).some((n) => words.test(n.toLowerCase()));
  const turning = of(found.position?.filter((_, j) => kinds?.[j] !== 'prismatic'));
  // Two turns: no joint of an arm goes farther in radians, and hardly a log stays within in degrees.
  const unitOf = (list, words) => of(list).some((c) => words.test(c.unit ?? ''));
  const degrees = says(found.position, /deg/) || unitOf(found.position, /deg|°/i) || largest(turning) > 4 * Math.PI;
  return { position: degrees ? 'deg' : 'rad', velocity: degrees || says(found.velocity, /deg/) ? 'deg/s' : 'rad/s', torque: says(found.torque, /current(?!_?as_?torque)|(^|[^a-z])i([^a-z]|$)|\[a\]/) || unitOf(found.torque, /^A$/) ? 'A' : unitOf(found.torque, /^m\s*N/) ? 'mN m' : 'N m', time: timeUnit(columns.find((c) => c.name === found.time)) };
}

function timeUnit(column) {
  if (!column) return 's';
  if (['s', 'ms', 'us', 'ns'].includes(column.unit)) return column.unit;
  const named = /(^|[^a-z])(ms|us|ns)([^a-z]|$)|milli|micro|nano/.exec(column.name.toLowerCase());
  if (named) return named[2] ?? { milli: 'ms', micro: 'us', nano: 'ns' }[named[0]];
  const steps = column.values.slice(1, 200).map((v, i) => v - column.values[i]).filter((d) => d > 0).sort((a, b) => a - b);
  const step = steps[Math.floor(steps.length / 2)] ?? 0.01;
  // Controllers write between every 0.1 ms and every 0.1 s.
  return step >= 1e5 ? 'ns' : step >= 1e2 ? 'us' : step >= 0.5 ? 'ms' : 's';
}
