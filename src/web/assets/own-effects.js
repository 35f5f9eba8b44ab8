// Effects with formulas of the user's own: written out, or of the lab's catalogue.
import { unmarkAround } from './api.js';
import { fill, h, labelled } from './dom.js';
import { catalogue, typeset } from './effect-catalogue.js';
import { OwnEffectForm, definition, entries, jointAndPart } from './own-effect-form.js';

const EXAMPLE = () => ({ name: 'counterbalance', joint: '', expression: 'b*sin(q - q0)/sqrt(1 - rho*cos(q - q0))', declared: false, channels: [],
  parameters: [{ name: 'b', unit: 'N m', low: '', high: '' }, { name: 'q0', unit: 'rad', low: '-1', high: '1' }, { name: 'rho', unit: '1', low: '0.05', high: '0.995' }] });

export class OwnEffects {
  /** `place`: where they stand; `add`: the button for a new one; `choose`: the drop-down of the catalogue; `joints()`: names of the robot's joints. */
  constructor(place, add, choose, joints) {
    Object.assign(this, { place, choose, joints, list: [], entries: [] });
    add.addEventListener('click', () => { this.list.push(EXAMPLE()); this.draw(); });
    choose.addEventListener('change', () => this.use(choose.value));
  }

  /** Looks at the catalogue; one that cannot be read, for want of a token, is shown as empty. */
  async look() {
    this.entries = await catalogue().catch(() => []);
    fill(this.choose, h('option', { value: '' }, 'choose one'), this.entries.map((e) => h('option', { value: e.name }, e.name)));
    this.choose.closest('.field').hidden = !this.entries.length;
  }

  /** Names of the catalogue. */
  get kept() {
    return this.entries.map((e) => e.name);
  }

  saved() {
    return this.look();
  }

  remove(i) {
    this.list.splice(i, 1);
    this.draw();
  }

  use(name) {
    const entry = this.entries.find((e) => e.name === name);
    this.choose.value = '';
    if (!entry) return;
    const taken = this.list.map((e) => e.name);
    const free = [name, ...Array.from({ length: taken.length + 1 }, (_, k) => `${name}_${k + 2}`)].find((n) => !taken.includes(n));
    this.list.push({ use: name, entry, name: free, joint: entry.definition.joint ?? '', declared: entry.definition.declared ?? false });
    this.draw();
  }

  /** As the request has it; nothing without an effect. */
  value() {
    const joint = (e) => (this.joints().includes(e.joint) ? e.joint : this.joints()[0]);
    const one = (e) => (e.use ? { use: e.use, name: e.name === e.use ? undefined : e.name, joint: joint(e), declared: e.declared } : definition(e, joint(e)));
    return this.list.length ? this.list.map(one) : undefined;
  }

  draw() {
    fill(this.place, this.list.map((effect, i) => (effect.use ? this.used(effect, i) : new OwnEffectForm(effect, i, this).draw())));
  }

  /** One of the catalogue: its formula stands there, its joint and name are of this request. */
  used(effect, i) {
    const at = `/effects/${i}`;
    const id = (part) => `own-${i}-${part}`;
    const name = h('input', { id: id('name'), value: effect.name, 'data-pointer': `${at}/name`, autocomplete: 'off', spellcheck: 'false', oninput: (e) => { effect.name = e.target.value; unmarkAround(e.target); } });
    const copy = () => { this.list[i] = { ...entries(effect.entry.definition), name: effect.name, joint: effect.joint, declared: effect.declared }; this.draw(); };
    const [joint, part] = jointAndPart(effect, at, id, this.joints());
    return h('fieldset', { 'data-pointer': at }, h('legend', {}, `Own effect ${i + 1}: ${effect.use} of the lab`), h('p', { class: 'formula' }, typeset(effect.entry)),
      h('div', { class: 'halves' }, h('div', { class: 'field' }, labelled('Name', id('name'), 'own_effect'), name), joint), part,
      h('div', { class: 'actions' }, h('button', { type: 'button', onclick: copy }, 'Edit a copy'), h('button', { type: 'button', onclick: () => this.remove(i) }, 'Remove the effect')));
  }
}
