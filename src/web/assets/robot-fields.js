// Inputs that edit one document: each knows its place in it, and carries the pointer that the interface names errors by.
import { h } from './dom.js';

const RADIANS = Math.PI / 180;

export class Fields {
  /** `changed` is called after every change. */
  constructor(doc, changed) {
    Object.assign(this, { doc, changed, degrees: true });
  }

  get angle() {
    return this.degrees ? '°' : 'rad';
  }

  read(path) {
    return path.reduce((at, key) => at?.[key], this.doc);
  }

  write(path, value, otherwise) {
    const parent = path.slice(0, -1).reduce((at, key, i) => (at[key] ??= typeof path[i + 1] === 'number' ? structuredClone(otherwise ?? []) : {}), this.doc);
    parent[path.at(-1)] = value;
    this.changed();
  }

  text(path, { id, label, cell }) {
    return h('input', { id, class: cell ? 'cell-name' : null, value: this.read(path) ?? '', 'aria-label': label, 'data-pointer': this.pointer(path), oninput: (e) => this.write(path, e.target.value) });
  }

  /** Where the numbers of an object come from; empty is left out. `path`: of the object. */
  source(path, of, words = 'Source') {
    return h('label', { class: 'stacked' }, words, this.sourceInput(path, { 'aria-label': `${of}: source` }));
  }

  sourceInput(path, options) {
    const input = h('input', { ...options, value: this.read(path).source ?? '', placeholder: 'data sheet, CAD, …', 'data-pointer': this.pointer([...path, 'source']), oninput: () => {
      const object = this.read(path);
      if (input.value.trim()) object.source = input.value;
      else delete object.source;
      this.changed();
    } });
    return input;
  }

  pointer(path) {
    return `/robot/${path.join('/')}`;
  }

  /**
   * A number. `angle`: kept in radians, shown as chosen. `required`: empty is an error that the interface names; else empty is null. `pair`: one end of a list of
   * two, which is null as long as both are empty. `otherwise`: the list that stands for one that is left out.
   */
  number(path, { id, label, angle, required, cell, pair, otherwise }) {
    const factor = angle && this.degrees ? RADIANS : 1;
    const kept = this.read(path) ?? otherwise?.[path.at(-1)];
    const shown = typeof kept === 'number' ? String(Number((kept / factor).toPrecision(factor === 1 ? 12 : 7))) : kept ?? '';
    const input = h('input', { id, class: cell ? 'cell-number' : null, value: shown, inputmode: 'decimal', 'aria-label': label, 'data-pointer': this.pointer(pair ? path.slice(0, -1) : path), autocomplete: 'off',
      // Errors name both ends of a pair at once, and angles as the document has them.
      'data-label': pair ? label.replace(/ ?\b(lowest|highest)\b/, '') : null, 'data-unit': factor === 1 ? null : 'rad' });
    input.addEventListener('input', () => {
      const text = input.value.trim().replace('−', '-').replace(/^(-?\d+),(\d+)$/, '$1.$2');
      const number = text === '' ? null : Number.isFinite(Number(text)) ? Number(text) * factor : text;
      if (pair) this.writePair(path, number);
      else this.write(path, number ?? (required ? '' : null), otherwise);
    });
    return input;
  }

  writePair(path, number) {
    const list = [...(this.read(path.slice(0, -1)) ?? [null, null])];
    list[path.at(-1)] = number;
    this.write(path.slice(0, -1), list.every((v) => v === null) ? null : list);
  }
}
