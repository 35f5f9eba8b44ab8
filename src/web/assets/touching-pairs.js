// Pairs of links that may touch: self-collision leaves them out, beside neighbours.
import { fill, h, term } from './dom.js';

const AT = '/constraints/space/self_collision/ignore';

export class TouchingPairs {
  /** `changed` is called after every change. */
  constructor(place, changed) {
    Object.assign(this, { place, changed, joints: [], list: [] });
  }

  /** Another robot has other links: pairs of links that it does not have are gone. */
  of(joints) {
    this.joints = joints;
    this.list = this.list.filter((pair) => pair.every((name) => joints.includes(name)));
    this.draw();
  }

  /** From `self_collision` of a request. */
  set(self) {
    this.list = (self?.ignore ?? []).map((pair) => [...pair]);
    this.draw();
  }

  /** For `self_collision.ignore` of a request. */
  value() {
    return this.list.length ? this.list : undefined;
  }

  has(pair) {
    return this.list.some((one) => pair.every((name) => one.includes(name)));
  }

  add(pair) {
    if (!this.has(pair)) this.list.push(pair);
    this.draw();
    this.changed();
  }

  /** Links that one of `joint` could touch: neighbours, which always do, are left out by the search itself. */
  partners(joint) {
    const at = this.joints.indexOf(joint);
    return this.joints.filter((_, k) => Math.abs(k - at) > 1);
  }

  choice(i, end, names) {
    const pair = this.list[i];
    return h('select', { class: 'narrow', id: `touch-${i}-${end}`, 'aria-label': `Pair ${i + 1}: ${['one link', 'the other link'][end]}`, 'data-pointer': `${AT}/${i}/${end}`, onchange: (e) => {
      pair[end] = e.target.value;
      if (!this.partners(pair[0]).includes(pair[1])) [pair[1]] = this.partners(pair[0]);
      this.draw();
      this.changed();
    } }, names.map((name) => h('option', { value: name, selected: name === pair[end] }, name)));
  }

  draw() {
    const focused = document.activeElement?.id;
    const first = this.joints.filter((name) => this.partners(name).length);
    const row = (pair, i) => h('div', { class: 'row field' }, this.choice(i, 0, first), 'and', this.choice(i, 1, this.partners(pair[0])),
      h('button', { type: 'button', class: 'quiet', 'aria-label': `Remove pair ${i + 1}`, onclick: () => { this.list.splice(i, 1); this.draw(); this.changed(); } }, '✕'));
    const next = () => first.flatMap((name) => this.partners(name).map((other) => [name, other])).find((pair) => !this.has(pair));
    fill(this.place, h('div', { class: 'row field' }, h('span', { class: 'labelled label' }, term('touching_pairs', 'Pairs that may touch')), h('button', { type: 'button', id: 'touch-add', disabled: !next(), onclick: () => this.add(next()) }, 'Add pair')),
      this.list.map(row));
    if (focused?.startsWith('touch-')) document.getElementById(focused)?.focus();
  }
}
