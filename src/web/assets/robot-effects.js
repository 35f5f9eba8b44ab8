// Own effects of a robot: every identification of it has them. A part of the editor, and a table on the robot's page.
import { postJson } from './api.js';
import { h, labelled, table } from './dom.js';
import { PAUSE, catalogue, typeset } from './effect-catalogue.js';
import { OwnEffects } from './own-effects.js';

/** The part of the editor, around the field `effects` of the document. */
export class RobotEffects {
  constructor(fields) {
    const [place, add] = [h('div', { id: 'own-effects-list' }), h('button', { type: 'button', id: 'own-effects-add' }, 'Write an effect')];
    const choose = h('select', { id: 'own-effects-choose' });
    this.fields = fields;
    this.count = h('span', { class: 'tag' });
    this.own = new OwnEffects({ place, add, choose, joints: () => fields.doc.joints.map((joint) => joint.name), at: '/robot/effects', changed: () => this.write() });
    this.element = h('details', { id: 'own-effects', 'data-pointer': '/robot/effects' }, h('summary', {}, 'Own effects ', this.count),
      h('p', { class: 'help' }, 'Torques that formulas of yours add to a joint. Every identification of this robot has them: tested like every effect, or declared as a part of the model.'), place,
      h('div', { class: 'field', hidden: true }, labelled('From the lab’s catalogue', 'own-effects-choose', 'effect_catalogue'), choose), h('div', { class: 'actions' }, add));
    this.own.look().then(() => this.read());
  }

  /** The document is another. */
  read() {
    this.own.set(this.fields.doc.effects);
    this.say();
  }

  /** Joints may have other names: the choice of a joint lists them. */
  follow() {
    const names = this.own.joints().join();
    if (names !== this.names) this.read();
    this.names = names;
  }

  write() {
    const { doc } = this.fields;
    doc.effects = this.own.value();
    if (!doc.effects) delete doc.effects;
    this.say();
    // Half a formula would be refused.
    clearTimeout(this.waiting);
    if (!this.own.unfinished) this.waiting = setTimeout(() => this.fields.changed(), PAUSE);
  }

  say() {
    const { length } = this.own.list;
    this.count.textContent = String(length);
    this.count.hidden = !length;
  }
}

/** The effects that a document has, as a table; nothing without any. */
export async function effectTable({ effects }) {
  if (!effects?.length) return null;
  const kept = effects.some((e) => typeof e === 'string' || e.use) ? await catalogue().catch(() => []) : [];
  const rows = await Promise.all(effects.map((effect) => rowOf(effect, kept)));
  return table([
    { head: 'Name', cell: (r) => h('span', { class: 'mono' }, r.name), sort: (r) => r.name }, { head: 'Torque', cell: (r) => (r.shown ? typeset(r.shown) : '–') }, { head: 'Joint', cell: (r) => r.joint ?? '–', sort: (r) => r.joint ?? '' },
    { head: 'Part of the model', term: 'own_effect', cell: (r) => (r.declared ? 'declared' : 'tested like every effect') },
    { head: 'Source', term: 'effect_catalogue', cell: (r) => (r.use ? `${r.use} of the lab’s catalogue` : 'this robot') },
  ], rows, { caption: 'In every identification of this robot' });
}

/** `{name, joint, declared, use, shown}`; `shown` is the definition with its formula. */
async function rowOf(effect, kept) {
  const { use, ...own } = typeof effect === 'string' ? { use: effect } : effect;
  const shown = use ? kept.find((e) => e.name === use) : await postJson('/effect-preview', effect).catch(() => ({ definition: effect }));
  return { name: use, joint: shown?.definition.joint, declared: shown?.definition.declared, ...own, use, shown };
}
