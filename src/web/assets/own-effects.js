// Effects with formulas of the user's own: written out, or of the lab's catalogue. Of a request, and of a robot.
import { fill, h, labelled } from './dom.js';
import { catalogue, formulaPlace, typeset, unfinished } from './effect-catalogue.js';
import { unmarkAround } from './field-errors.js';
import { OwnEffectForm, definition, entries, jointAndPart } from './own-effect-form.js';

const EXAMPLE = () => ({ name: 'counterbalance', joint: '', expression: 'b*sin(q - q0)/sqrt(1 - rho*cos(q - q0))', declared: false, channels: [],
  parameters: [{ name: 'b', unit: 'N m', low: '', high: '' }, { name: 'q0', unit: 'rad', low: '-1', high: '1' }, { name: 'rho', unit: '1', low: '0.05', high: '0.995' }] });
/** What a use of the catalogue says itself, to see whether it was changed. */
const said = ({ name, joint, declared }) => JSON.stringify([name, joint, declared]);

export class OwnEffects {
  /**
   * `place`: where they stand; `add`: the button for a new one; `choose`: the drop-down of the catalogue; `joints()`: names of the
   * robot's joints; `at`: pointer of the field in the document; `changed()` is called after every change.
   */
  constructor({ place, add, choose, joints, at = '/effects', changed = () => {} }) {
    Object.assign(this, { place, choose, joints, at, changed, list: [], entries: [] });
    add.addEventListener('click', () => { this.list.push(EXAMPLE()); this.redraw(); });
    choose.addEventListener('change', () => this.use(choose.value));
    ['input', 'change'].forEach((name) => place.addEventListener(name, () => this.changed()));
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
    this.redraw();
  }

  use(name) {
    const entry = this.entries.find((e) => e.name === name);
    this.choose.value = '';
    if (!entry) return;
    const taken = this.list.map((e) => e.name);
    const free = [name, ...Array.from({ length: taken.length + 1 }, (_, k) => `${name}_${k + 2}`)].find((n) => !taken.includes(n));
    this.list.push({ use: name, entry, name: free, joint: entry.definition.joint ?? '', declared: entry.definition.declared ?? false });
    this.redraw();
  }

  /** From the field `effects` of a document. */
  set(list) {
    this.list = (Array.isArray(list) ? list : []).map((item) => this.read(item ?? {}));
    this.draw();
  }

  read(given) {
    const { use, ...own } = typeof given === 'string' ? { use: given } : given;
    if (!use) return entries(given);
    const entry = this.entries.find((e) => e.name === use);
    const of = { name: use, joint: entry?.definition.joint ?? '', declared: entry?.definition.declared ?? false, ...own };
    return { ...of, use, entry, given, was: said(of) };
  }

  /** As the document has it; nothing without an effect. What was not changed stays as it was given. */
  value() {
    const joint = (e) => e.joint || this.joints()[0];
    const used = (e) => (e.was === said(e) ? e.given : { use: e.use, name: e.name === e.use ? undefined : e.name, joint: joint(e), declared: e.declared });
    return this.list.length ? this.list.map((e) => (e.use ? used(e) : definition(e, joint(e)))) : undefined;
  }

  /** Whether somebody is still writing one of them. */
  get unfinished() {
    return this.list.some((e) => !e.use && unfinished(definition(e)));
  }

  draw() {
    fill(this.place, this.list.map((effect, i) => (effect.use ? this.used(effect, i) : new OwnEffectForm(effect, i, this).draw())));
  }

  redraw() {
    this.draw();
    this.changed();
  }

  /** One of the catalogue: its formula stands there, its joint and name are of this document. */
  used(effect, i) {
    const at = `${this.at}/${i}`;
    const id = (part) => `own-${i}-${part}`;
    const name = h('input', { id: id('name'), value: effect.name, 'data-pointer': `${at}/name`, 'data-label': `Name of own effect ${i + 1}`, autocomplete: 'off', spellcheck: 'false', oninput: (e) => { effect.name = e.target.value; unmarkAround(e.target); } });
    const copy = () => { this.list[i] = { ...entries(effect.entry.definition), name: effect.name, joint: effect.joint, declared: effect.declared }; this.redraw(); };
    const [joint, part] = jointAndPart(effect, at, id, this.joints());
    return h('fieldset', { 'data-pointer': at }, h('legend', {}, `Own effect ${i + 1}: ${effect.use} of the lab`), formulaPlace(effect.entry ? typeset(effect.entry) : 'The lab’s catalogue has no effect of this name.'),
      h('div', { class: 'halves' }, h('div', { class: 'field' }, labelled('Name', id('name'), 'own_effect'), name), joint), part,
      h('div', { class: 'actions' }, h('button', { type: 'button', disabled: !effect.entry, onclick: copy }, 'Edit a copy'), h('button', { type: 'button', onclick: () => this.remove(i) }, 'Remove the effect')));
  }
}
