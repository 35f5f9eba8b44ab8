// Effects with formulas of the user's own, as a part of a form: every input carries the pointer that errors are named by.
import { unmarkAround } from './api.js';
import { fill, h, labelled } from './dom.js';

const EXAMPLE = () => ({ name: 'counterbalance', joint: '', expression: 'b*sin(q1 - q0)/sqrt(1 - rho*cos(q1 - q0))', declared: false,
  parameters: [{ name: 'b', unit: 'N m', low: '', high: '' }, { name: 'q0', unit: 'rad', low: '-1', high: '1' }, { name: 'rho', unit: '1', low: '0.05', high: '0.995' }] });
/** What is no number goes to the server as it is, which says so at its field. */
const numeric = (text) => (text.trim() === '' ? undefined : Number.isFinite(Number(text)) ? Number(text) : text);

export class OwnEffects {
  /** `joints()`: names of the robot's joints. */
  constructor(place, add, joints) {
    Object.assign(this, { place, joints, list: [] });
    add.addEventListener('click', () => { this.list.push(EXAMPLE()); this.draw(); });
  }

  /** As the request has it; nothing without an effect. */
  value() {
    const parameter = (p) => ({ name: p.name, unit: p.unit, low: numeric(p.low), high: numeric(p.high) });
    const one = (e) => ({ ...e, joint: e.joint || this.joints()[0], parameters: e.parameters.map(parameter) });
    return this.list.length ? this.list.map(one) : undefined;
  }

  draw() {
    fill(this.place, this.list.map((effect, i) => this.one(effect, i)));
  }

  input(of, key, pointer, options) {
    return h('input', { value: of[key], 'data-pointer': pointer, autocomplete: 'off', spellcheck: 'false', oninput: (e) => { of[key] = e.target.value; unmarkAround(e.target); }, ...options });
  }

  one(effect, i) {
    const at = `/effects/${i}`;
    const id = (part) => `own-${i}-${part}`;
    const names = this.joints();
    const joint = h('select', { id: id('joint'), 'data-pointer': `${at}/joint`, onchange: (e) => { effect.joint = e.target.value; } }, names.map((n) => h('option', { value: n, selected: n === (effect.joint || names[0]) }, n)));
    const declared = h('select', { id: id('declared'), 'data-pointer': `${at}/declared`, onchange: (e) => { effect.declared = e.target.value === 'yes'; } }, [['no', 'tested like every effect'], ['yes', 'declared: in the model']].map(([k, t]) => h('option', { value: k, selected: (k === 'yes') === effect.declared }, t)));
    const cell = (p, k, key, label) => h('td', {}, h('div', { class: 'field' }, this.input(p, key, `${at}/parameters/${k}/${key}`, { class: 'narrow', 'aria-label': `${label} of parameter ${k + 1}` })));
    const row = (p, k) => h('tr', {}, [['name', 'Name'], ['unit', 'Unit'], ['low', 'Lowest value'], ['high', 'Highest value']].map(([key, label]) => cell(p, k, key, label)),
      h('td', {}, h('button', { type: 'button', class: 'quiet', 'aria-label': `Remove ${p.name || `parameter ${k + 1}`}`, onclick: () => { effect.parameters.splice(k, 1); this.draw(); } }, '✕')));
    const head = (text) => h('th', { scope: 'col', 'data-own': '' }, text);
    return h('fieldset', { 'data-pointer': at }, h('legend', {}, `Own effect ${i + 1}`),
      h('div', { class: 'halves' }, h('div', { class: 'field' }, labelled('Name', id('name'), 'own_effect'), this.input(effect, 'name', `${at}/name`, { id: id('name') })), h('div', { class: 'field' }, labelled('Joint', id('joint'), 'own_effect'), joint)),
      h('div', { class: 'field' }, labelled('Torque that it adds', id('expression'), 'own_effect'), this.input(effect, 'expression', `${at}/expression`, { id: id('expression'), class: 'mono' }),
        h('p', { class: 'help' }, 'q1, qd1, qdd1: position, speed and acceleration of joint 1. + - * / ^, sin cos tan tanh exp ln sqrt abs sign, pi. Every other name is a parameter.')),
      h('div', { class: 'field', 'data-pointer': `${at}/parameters` }, h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': `Parameters of own effect ${i + 1}` }, h('table', { class: 'entry' }, h('thead', {}, h('tr', {}, ['Parameter', 'Unit', 'from', 'to'].map(head), h('th', { scope: 'col', 'data-own': '' }, h('span', { class: 'unseen' }, 'Remove')))), h('tbody', {}, effect.parameters.map(row)))),
        h('p', { class: 'help' }, 'SI units side by side: N m/rad. A range is needed where the formula is not linear in the parameter.')),
      h('div', { class: 'field' }, labelled('Part of the model', id('declared'), 'own_effect'), declared),
      h('div', { class: 'actions' }, h('button', { type: 'button', onclick: () => { effect.parameters.push({ name: '', unit: '1', low: '', high: '' }); this.draw(); } }, 'Add a parameter'), h('button', { type: 'button', onclick: () => { this.list.splice(i, 1); this.draw(); } }, 'Remove the effect')));
  }
}
