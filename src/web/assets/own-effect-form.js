// One own effect as a part of a form: every input carries the pointer that errors are named by.
import { explain } from './api.js';
import { fill, h, labelled } from './dom.js';
import { Preview, keep } from './effect-catalogue.js';
import { nameAt, unmark, unmarkAround } from './field-errors.js';

/** What is no number goes to the server as it is, which says so at its field. */
const numeric = (text) => (text.trim() === '' ? undefined : Number.isFinite(Number(text)) ? Number(text) : text);
const some = (list) => (list.length ? list : undefined);
const text = (value) => (value === undefined || value === null ? '' : String(value));

/** The entries of a form as the interface has them. */
export function definition(effect, joint) {
  const parameter = (p) => ({ name: p.name, unit: p.unit, low: numeric(p.low), high: numeric(p.high) });
  const channel = (c) => ({ name: c.name, unit: c.unit, reference: numeric(c.reference) });
  return { name: effect.name, joint, expression: effect.expression, declared: effect.declared, parameters: effect.parameters.map(parameter), channels: some(effect.channels.map(channel)) };
}

/** The other way round. */
export function entries(given) {
  const parameter = (p) => ({ name: p.name, unit: p.unit, low: text(p.low), high: text(p.high) });
  const channel = (c) => ({ name: c.name, unit: c.unit ?? '1', reference: text(c.reference) });
  return { name: given.name ?? '', joint: given.joint ?? '', expression: given.expression ?? '', declared: given.declared ?? false, parameters: (given.parameters ?? []).map(parameter), channels: (given.channels ?? []).map(channel) };
}

/** A choice of a joint, and whether the effect is declared: of every effect, written out or of the catalogue. */
export function jointAndPart(effect, at, id, names) {
  // A joint that the robot does not have stays chosen: what is wrong with it is said at its field.
  const all = effect.joint && !names.includes(effect.joint) ? [effect.joint, ...names] : names;
  const joint = h('select', { id: id('joint'), 'data-pointer': `${at}/joint`, onchange: (e) => { effect.joint = e.target.value; unmarkAround(e.target); } }, all.map((n) => h('option', { value: n, selected: n === (effect.joint || names[0]) }, n)));
  const declared = h('select', { id: id('declared'), 'data-pointer': `${at}/declared`, onchange: (e) => { effect.declared = e.target.value === 'yes'; } }, [['no', 'tested like every effect'], ['yes', 'declared: in the model']].map(([k, t]) => h('option', { value: k, selected: (k === 'yes') === effect.declared }, t)));
  return [h('div', { class: 'field' }, labelled('Joint', id('joint'), 'own_effect'), joint), h('div', { class: 'field' }, labelled('Part of the model', id('declared'), 'own_effect'), declared)];
}

export class OwnEffectForm {
  /** `host`, the list of effects, has `at`, `joints()`, `redraw()`, `remove(i)`, `kept` (names of the catalogue) and `saved()`. */
  constructor(effect, i, host) {
    Object.assign(this, { effect, i, host, at: `${host.at}/${i}`, state: h('span', { class: 'soft', role: 'status' }), trouble: h('div') });
    this.preview = new Preview(() => this.definition(), (pointer) => nameAt(this.element, `${this.at}${pointer}`));
  }

  definition() {
    return definition(this.effect, this.effect.joint || this.host.joints()[0]);
  }

  input(of, key, pointer, options) {
    return h('input', { value: of[key], 'data-pointer': pointer, autocomplete: 'off', spellcheck: 'false', ...options, oninput: (e) => { of[key] = e.target.value; unmarkAround(e.target); this.preview.soon(); options?.oninput?.(); } });
  }

  /** A table with a row for every entry of `list`; `columns`: [key, head, label of the field]. */
  table(list, key, what, columns) {
    const cell = (entry, k, [field, , label]) => h('td', {}, h('div', { class: 'field' }, this.input(entry, field, `${this.at}/${key}/${k}/${field}`, { class: 'narrow', 'aria-label': `${label} of ${what} ${k + 1}` })));
    const row = (entry, k) => h('tr', {}, columns.map((column) => cell(entry, k, column)),
      h('td', {}, h('button', { type: 'button', class: 'quiet', 'aria-label': `Remove ${entry.name || `${what} ${k + 1}`}`, onclick: () => { list.splice(k, 1); this.host.redraw(); } }, '✕')));
    const head = (words) => h('th', { scope: 'col', 'data-own': '' }, words);
    return h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': `${what}s of own effect ${this.i + 1}` }, h('table', { class: 'entry' },
      h('thead', {}, h('tr', {}, columns.map(([, words]) => head(words)), h('th', { scope: 'col', 'data-own': '' }, h('span', { class: 'unseen' }, 'Remove')))), h('tbody', {}, list.map(row))));
  }

  parameters() {
    return h('div', { class: 'field', 'data-pointer': `${this.at}/parameters` }, this.table(this.effect.parameters, 'parameters', 'parameter', [['name', 'Parameter', 'Name'], ['unit', 'Unit', 'Unit'], ['low', 'From', 'Lowest value'], ['high', 'To', 'Highest value']]),
      h('p', { class: 'help' }, 'SI units side by side: N m/rad. A range is needed where the formula is not linear in the parameter.'));
  }

  channels() {
    const { channels } = this.effect;
    return channels.length ? h('div', { class: 'field', 'data-pointer': `${this.at}/channels` }, this.table(channels, 'channels', 'quantity', [['name', 'Quantity', 'Name'], ['unit', 'Unit', 'Unit'], ['reference', 'Elsewhere', 'Value elsewhere']]),
      h('p', { class: 'help' }, 'Further quantities of the log, named as in its table of columns. “Elsewhere” is the value along motions that have none: designs, exports.')) : null;
  }

  async save(button) {
    button.disabled = true;
    unmark(this.element);
    fill(this.trouble);
    fill(this.state);
    try {
      await keep(this.definition());
      await this.host.saved();
      fill(button, this.label());
      fill(this.state, 'Saved to the lab.');
    } catch (error) {
      const errors = error.problem?.errors?.map((e) => ({ ...e, pointer: `${this.at}${e.pointer}` }));
      explain(this.trouble, error.problem ? Object.assign(error, { problem: { ...error.problem, errors } }) : error, this.element);
    } finally {
      button.disabled = false;
    }
  }

  label() {
    const { name } = this.effect;
    return this.host.kept.includes(name) ? `Replace ${name} in the lab` : 'Save to the lab';
  }

  draw() {
    const { effect, at, i } = this;
    const id = (part) => `own-${i}-${part}`;
    const save = h('button', { type: 'button', onclick: () => this.save(save) }, this.label());
    const renamed = { id: id('name'), oninput: () => { fill(save, this.label()); fill(this.state); } };
    const [joint, part] = jointAndPart(effect, at, id, this.host.joints());
    const add = (list, entry) => () => { list.push(entry); this.host.redraw(); };
    this.element = h('fieldset', { 'data-pointer': at }, h('legend', {}, `Own effect ${i + 1}`),
      h('div', { class: 'halves' }, h('div', { class: 'field' }, labelled('Name', id('name'), 'own_effect'), this.input(effect, 'name', `${at}/name`, { ...renamed, 'data-label': `Name of own effect ${i + 1}` })), joint),
      h('div', { class: 'field' }, labelled('Torque that it adds', id('expression'), 'own_effect'), this.input(effect, 'expression', `${at}/expression`, { id: id('expression'), class: 'mono', 'data-label': `Torque of own effect ${i + 1}` }), this.preview.place,
        h('p', { class: 'help' }, 'q, qd, qdd: position, speed and acceleration of its joint; q1, qd1, qdd1 those of joint 1. + - * / ^, sin cos tan tanh exp ln sqrt abs sign, pi. Every other name is a parameter.')),
      this.parameters(), this.channels(), part,
      h('div', { class: 'actions' }, h('button', { type: 'button', onclick: add(effect.parameters, { name: '', unit: '1', low: '', high: '' }) }, 'Add a parameter'), h('button', { type: 'button', onclick: add(effect.channels, { name: '', unit: '1', reference: '' }) }, 'Add a quantity'),
        save, h('button', { type: 'button', onclick: () => this.host.remove(i) }, 'Remove the effect'), this.state), this.trouble);
    return this.element;
  }
}
