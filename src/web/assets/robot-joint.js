// What is known of one joint's link: mass, shape, bounds.
import { h, mark, term } from './dom.js';

/** Parts of a joint that are terms of the glossary. */
const TERMS = { prior: 'prior', bounds: 'bounds' };
const INERTIA = ['xx', 'yy', 'zz', 'xy', 'xz', 'yz'];

export function jointDetails(fields, j, draw) {
  const joint = fields.doc.joints[j];
  const at = (...path) => ['joints', j, ...path];
  const slides = joint.kind === 'prismatic';
  const group = (title, ...parts) => h('div', { class: 'field', role: 'group', 'aria-label': `${joint.name}: ${title}` }, h('span', { class: 'label' }, title), parts);
  const number = (path, label, options = {}) => fields.number(at(...path), { label: `${joint.name}: ${label}`, ...options });
  const labelled = (text, input) => h('label', { class: 'stacked' }, text, input);
  const tags = [joint.prior ? 'prior' : null, joint.geometry?.length ? `${joint.geometry.length} capsule${joint.geometry.length > 1 ? 's' : ''}` : null, joint.bounds ? 'bounds' : null].filter(Boolean);
  return h('details', { id: `joint-${j}` }, h('summary', {}, joint.name, ' ', tags.map((t) => [h('span', { class: 'tag' }, t), ' '])),
    h('div', { class: 'halves field' }, labelled('Name of the link that the joint moves', fields.text(at('link'), { label: `${joint.name}: link` })),
      h('div', { class: 'stacked' }, h('span', { class: 'labelled' }, 'Long axis of the link', mark('long_axis', 'Long axis of a link')), h('select', { 'aria-label': `${joint.name}: long axis`, 'data-pointer': `/robot/joints/${j}/slender_axis`, onchange: (e) => { if (e.target.value) joint.slender_axis = e.target.value; else delete joint.slender_axis; fields.changed(); } },
        ['', 'x', 'y', 'z'].map((a) => h('option', { value: a, selected: (joint.slender_axis ?? '') === a }, a || 'none'))))),
    sources(fields, joint, at), prior(fields, joint, { at, group, number, labelled, slides, draw }), capsules(fields, joint, j, { at, number, draw }), bounds(fields, joint, { at, group, number, labelled, slides, draw }));
}

/** Where what the tables above say of the joint comes from; priors, capsules and bounds have a source of their own. */
function sources(fields, joint, at) {
  const placed = ['placement', 'mdh'].find((key) => joint[key]);
  const parts = [[[], 'Source of the joint'], placed ? [[placed], 'Source of its placement'] : null, [['limits'], 'Source of its limits']].filter(Boolean);
  return h('div', { class: 'three' }, parts.map(([path, words]) => fields.source(at(...path), `${joint.name}, ${path[0] ?? 'joint'}`, words)));
}

function switched(fields, joint, key, words, make, draw, content) {
  const on = h('input', { type: 'checkbox', checked: Boolean(joint[key]), onchange: () => { if (on.checked) joint[key] = make(); else delete joint[key]; draw(); fields.changed(); } });
  return h('fieldset', {}, h('legend', {}, h('label', { class: 'inline' }, on, words), TERMS[key] ? mark(TERMS[key], words) : null), joint[key] ? content() : null);
}

function prior(fields, joint, { at, group, number, labelled, slides, draw }) {
  const make = () => ({ mass: 1, center_of_mass: [0, 0, 0], inertia: Object.fromEntries(INERTIA.map((k) => [k, ['xx', 'yy', 'zz'].includes(k) ? 0.01 : 0])), viscous: 0, coulomb: 0 });
  const per = slides ? ['N·s/m', 'N'] : ['N·m·s/rad', 'N·m'];
  return switched(fields, joint, 'prior', 'Known beforehand (prior)', make, draw, () => [
    h('div', { class: 'three' }, labelled('Mass (kg)', number(['prior', 'mass'], 'mass', { required: true })), labelled(`Viscous friction (${per[0]})`, number(['prior', 'viscous'], 'viscous friction')), labelled(`Coulomb friction (${per[1]})`, number(['prior', 'coulomb'], 'Coulomb friction'))),
    group('Centre of mass in the link frame (m)', h('div', { class: 'three' }, [0, 1, 2].map((i) => labelled('xyz'[i], number(['prior', 'center_of_mass', i], `centre of mass ${'xyz'[i]}`, { required: true }))))),
    group('Inertia about the centre of mass (kg·m²)', h('div', { class: 'three' }, INERTIA.map((k) => labelled(k, number(['prior', 'inertia', k], `inertia ${k}`, { required: true }))))),
    fields.source(at('prior'), `${joint.name}, prior`),
  ]);
}

function capsules(fields, joint, j, { at, number, draw }) {
  const list = joint.geometry ?? [];
  const line = (_, k) => h('div', { class: 'capsule' }, ['from', 'to'].map((end) => h('div', { class: 'three' }, [0, 1, 2].map((i) => h('label', { class: 'stacked' }, `${end} ${'xyz'[i]} (m)`, number(['geometry', k, end, i], `capsule ${k + 1} ${end} ${'xyz'[i]}`, { required: true }))))),
    h('div', { class: 'row' }, h('label', { class: 'stacked' }, 'Radius (m)', number(['geometry', k, 'radius'], `capsule ${k + 1} radius`, { required: true })), fields.source(at('geometry', k), `${joint.name}, capsule ${k + 1}`), h('button', { type: 'button', 'aria-label': `${joint.name}: remove capsule ${k + 1}`, onclick: () => { list.splice(k, 1); if (!list.length) delete joint.geometry; draw(); fields.changed(); } }, 'Remove')));
  const add = () => {
    joint.geometry = [...list, towards(nextJoint(fields.doc, j) ?? [0, 0, 0.1])];
    draw();
    fields.changed();
  };
  return h('fieldset', {}, h('legend', {}, 'Shape, as ', term('capsule', 'capsules'), ' in the link frame'), list.map(line), h('button', { type: 'button', onclick: add }, 'Add capsule'), h('p', { class: 'help' }, 'All points within the radius of a segment. Needed for self-collision, floors and obstacles.'));
}

/** Where the next joint is, in the frame of link `j`: most links are about as long. */
function nextJoint(doc, j) {
  const next = doc.joints[j + 1];
  return next?.placement?.xyz ?? (next?.mdh ? [next.mdh.d, -Math.sin(next.mdh.alpha) * next.mdh.r, Math.cos(next.mdh.alpha) * next.mdh.r] : null);
}

const towards = (to, radius = 0.06) => ({ from: [0, 0, 0], to: to.map((v) => Number(v.toFixed(4)) + 0), radius });

/** Capsules along all links that are long enough to have one, about as thick as arms of this size are; links that have a shape keep it. */
export function suggestShape(doc) {
  const reaches = doc.joints.map((_, j) => nextJoint(doc, j) ?? [0, 0, 0]);
  const whole = reaches.reduce((sum, p) => sum + Math.hypot(...p), 0);
  // An arm of one metre has links of about 12 cm; shorter pieces are inside those of their neighbours.
  const radius = Number(Math.min(Math.max(0.06 * whole, 0.02), 0.12).toFixed(3));
  doc.joints.forEach((joint, j) => { if (!joint.geometry?.length && Math.hypot(...reaches[j]) > 1.5 * radius) joint.geometry = [towards(reaches[j], radius)]; });
}

function bounds(fields, joint, { at, group, number, labelled, slides, draw }) {
  const pair = (path, words) => h('div', { class: 'pair-of' }, [0, 1].map((end) => labelled(`${words}, ${['lowest', 'highest'][end]}`, number(['bounds', ...path, end], `${words} ${['lowest', 'highest'][end]}`, { pair: true }))));
  const per = slides ? ['N·s/m', 'N'] : ['N·m·s/rad', 'N·m'];
  return switched(fields, joint, 'bounds', 'Bounds of its parameters', () => ({ mass: [0.1, 10] }), draw, () => [
    pair(['mass'], 'Mass (kg)'),
    group('Centre of mass (m)', [0, 1, 2].map((i) => boundOfCentre(fields, joint, number, labelled, i))),
    group('Inertia about the centre of mass (kg·m²)', INERTIA.map((k) => pair(['inertia', k], k))),
    pair(['viscous'], `Viscous friction (${per[0]})`), pair(['coulomb'], `Coulomb friction (${per[1]})`), fields.source(at('bounds'), `${joint.name}, bounds`)]);
}

/** Three pairs or none: an axis without bounds has wide ones. */
function boundOfCentre(fields, joint, number, labelled, i) {
  const WIDE = [-2, 2];
  const input = (end) => {
    const field = number(['bounds', 'center_of_mass', i, end], `centre of mass ${'xyz'[i]} ${['lowest', 'highest'][end]}`);
    // Before the field writes: it needs all three pairs to be there.
    field.addEventListener('input', () => { joint.bounds.center_of_mass ??= [0, 1, 2].map(() => [...WIDE]); }, { capture: true });
    return field;
  };
  return h('div', { class: 'pair-of' }, [0, 1].map((end) => labelled(`${'xyz'[i]}, ${['lowest', 'highest'][end]}`, input(end))));
}
