// Floors, walls and boxes that the arm avoids, as rows of a form.
import { fill, h } from './dom.js';

const NEW = {
  floor: { kind: 'half_space', name: 'floor', normal: [0, 0, 1], offset: 0 },
  wall: { kind: 'half_space', name: 'wall', normal: [1, 0, 0], offset: -0.8 },
  box: { kind: 'box', name: 'table', center: [0.8, 0, 0.2], size: [0.6, 1, 0.4] },
};
const PLACES = { half_space: 'half_spaces', box: 'boxes' };
const FIELDS = {
  half_space: [['normal', 'Normal, towards the arm', 3], ['offset', 'Distance along it (m)', 1]],
  box: [['center', 'Centre (m)', 3], ['size', 'Edges (m)', 3]],
};

export class Obstacles {
  constructor(place, changed) {
    Object.assign(this, { place, changed, rows: [] });
  }

  /** A new row; `placed` is what is known of where it stands. */
  add(what, placed = {}) {
    this.rows.push({ ...structuredClone(NEW[what]), ...placed });
    this.show();
  }

  /** From `constraints.space` of a request. */
  set(space) {
    const each = (kind) => (space?.[PLACES[kind]] ?? []).map((o) => ({ kind, ...o }));
    this.rows = [...each('half_space'), ...each('box')];
    this.show();
  }

  /** For `constraints.space` of a request. */
  value() {
    const each = (kind) => this.rows.filter((r) => r.kind === kind).map(({ kind: _, ...rest }) => rest);
    const [half_spaces, boxes] = [each('half_space'), each('box')];
    return { half_spaces: half_spaces.length ? half_spaces : undefined, boxes: boxes.length ? boxes : undefined };
  }

  show() {
    fill(this.place, this.rows.map((row, i) => this.row(row, i)));
    this.changed();
  }

  row(row, i) {
    const pointer = `/constraints/space/${PLACES[row.kind]}/${this.rows.slice(0, i).filter((r) => r.kind === row.kind).length}`;
    const called = (label) => `${row.name}: ${label.replace(/ \(.*\)$/, '').toLowerCase()}`;
    const input = (key, label, count) => h('input', { 'data-label': called(label), id: `obstacle-${i}-${key}`, value: Array.isArray(row[key]) ? row[key].join(', ') : row[key], 'data-pointer': `${pointer}/${key}`, oninput: (e) => {
      const parts = e.target.value.replaceAll('−', '-').split(/[\s,;]+/).filter(Boolean).map((t) => (Number.isFinite(Number(t)) ? Number(t) : t));
      row[key] = key === 'name' ? e.target.value : count === 1 ? parts[0] ?? null : parts;
      this.changed();
    } });
    const field = ([key, label, count]) => h('div', { class: 'field' }, h('label', { for: `obstacle-${i}-${key}` }, label), input(key, label, count));
    return h('fieldset', { class: 'obstacle', 'data-pointer': pointer, 'data-label': row.name || NEW[row.kind === 'box' ? 'box' : 'wall'].name }, h('legend', {}, row.kind === 'box' ? 'Box' : 'Plane: floor or wall'),
      h('div', { class: 'pair' }, field(['name', 'Name', 0]), h('div', { class: 'end' }, h('button', { type: 'button', 'aria-label': `Remove ${row.name}`, onclick: () => { this.rows.splice(i, 1); this.show(); } }, 'Remove'))),
      h('div', { class: 'pair' }, FIELDS[row.kind].map(field)));
  }
}
