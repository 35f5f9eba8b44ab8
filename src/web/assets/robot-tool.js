// A tool at the last link: its mass becomes part of what is known of that link.
import { fill, h } from './dom.js';

const KEYS = ['xx', 'yy', 'zz', 'xy', 'xz', 'yz'];
const numberOf = (text) => Number(text.trim().replace('−', '-').replace(',', '.'));

/** Inertia about a point at `offset` of a body with `mass` and `inertia` about its centre (parallel axes). */
function moved(inertia, mass, [x, y, z]) {
  const add = { xx: y * y + z * z, yy: x * x + z * z, zz: x * x + y * y, xy: -x * y, xz: -x * z, yz: -y * z };
  return Object.fromEntries(KEYS.map((k) => [k, inertia[k] + mass * add[k]]));
}

/** Two bodies as one: {mass, center_of_mass, inertia about the common centre}. */
export function joined(a, b) {
  const mass = a.mass + b.mass;
  if (!(mass > 0)) return a;
  const center = [0, 1, 2].map((i) => (a.mass * a.center_of_mass[i] + b.mass * b.center_of_mass[i]) / mass);
  const parts = [a, b].map((body) => moved(body.inertia, body.mass, body.center_of_mass.map((c, i) => c - center[i])));
  return { mass, center_of_mass: center, inertia: Object.fromEntries(KEYS.map((k) => [k, parts[0][k] + parts[1][k]])) };
}

export function toolForm(fields, draw) {
  const last = fields.doc.joints.at(-1);
  const input = (id, label, value = '0') => h('label', { class: 'stacked' }, label, h('input', { id: `tool-${id}`, value, inputmode: 'decimal', autocomplete: 'off' }));
  const place = h('div');
  const part = h('details', { id: 'tool-part' }, h('summary', {}, 'Add a tool'), h('p', { class: 'help' }, `Its mass is added to what is known of the last link, ${last.name}; with a radius it also gets a shape. All in the frame of that link.`),
    h('div', { class: 'three' }, input('mass', 'Mass (kg)', '1'), input('radius', 'Radius of its shape (m), 0 for none')), h('span', { class: 'label' }, 'Centre of mass (m)'), h('div', { class: 'three' }, ['x', 'y', 'z'].map((a) => input(a, a))),
    h('span', { class: 'label' }, 'Inertia about its centre of mass (kg·m²)'), h('div', { class: 'three' }, KEYS.map((k) => input(k, k))), place, h('div', { class: 'actions' }, h('button', { type: 'button', onclick: () => add() }, 'Add to the last link')));
  function add() {
    const value = (id) => numberOf(part.querySelector(`#tool-${id}`).value);
    const tool = { mass: value('mass'), center_of_mass: ['x', 'y', 'z'].map(value), inertia: Object.fromEntries(KEYS.map((k) => [k, value(k)])) };
    const numbers = [tool.mass, ...tool.center_of_mass, ...Object.values(tool.inertia), value('radius')];
    if (!numbers.every(Number.isFinite) || !(tool.mass > 0)) {
      fill(place, h('p', { class: 'field-error', role: 'alert' }, 'A tool has a mass above zero; every entry is a number.'));
      return;
    }
    const bare = { mass: 0, center_of_mass: [0, 0, 0], inertia: Object.fromEntries(KEYS.map((k) => [k, 0])) };
    last.prior = { ...(last.prior ?? {}), ...joined(last.prior ?? bare, tool) };
    if (value('radius') > 0) last.geometry = [...(last.geometry ?? []), { from: [0, 0, 0], to: tool.center_of_mass.map((c) => 2 * c), radius: value('radius') }];
    draw();
    fields.changed();
  }
  return part;
}
