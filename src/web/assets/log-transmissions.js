// What is done to columns beyond units, scale and sign: offsets, joints that several motors turn, columns in another file.
import { h, term } from './dom.js';

const QUANTITIES = ['position', 'velocity', 'torque'];
const WORDS = { position: 'Positions', velocity: 'Velocities', torque: 'Torques' };
const EMPTY = () => ({ coupling: '', position: {}, velocity: {}, torque: {} });

/** What is no number goes to the server as it is, which says so at its field. */
const numeric = (text) => (Number.isFinite(Number(text)) ? Number(text) : text);
const parts = (text) => text.replaceAll('−', '-').split(/[\s,]+/).filter(Boolean);
/** `1 0; 1 -1` → rows of numbers; lines separate rows as well. */
const rows = (text) => text.split(/[;\n]/).map((row) => parts(row).map(numeric)).filter((row) => row.length);
/** One number for all joints, or one per joint. */
const each = (text) => {
  const list = parts(text.replaceAll(';', ' ')).map(numeric);
  return list.length > 1 ? list : list[0];
};

export class LogTransmissions {
  /** `changed` is called after every change. */
  constructor(changed) {
    Object.assign(this, { changed, kept: EMPTY(), files: [] });
  }

  /** From what was kept for logs with these columns; `files`: names of all logs. */
  set(kept, files) {
    Object.assign(this, { kept: { ...EMPTY(), ...kept }, files });
  }

  get used() {
    return Boolean(this.kept.coupling) || QUANTITIES.some((q) => Object.values(this.kept[q]).some(Boolean));
  }

  /** Whether the columns of a quantity are in another file. */
  elsewhere(quantity) {
    return Boolean(this.kept[quantity].file);
  }

  /** Fields of `columns.position`, `velocity` or `torque` of a request. */
  of(quantity) {
    const { offset, matrix, file, headers } = this.kept[quantity];
    const other = file ? { file, headers: (headers ?? '').split(/[,;\n]+/).map((t) => t.trim()).filter(Boolean) } : {};
    return { offset: offset?.trim() ? each(offset) : undefined, matrix: matrix?.trim() ? rows(matrix) : undefined, ...other };
  }

  coupling() {
    return this.kept.coupling.trim() ? rows(this.kept.coupling) : undefined;
  }

  input(quantity, key, tag, options) {
    const at = `${quantity}-${key}`;
    const shown = this.kept[quantity][key] ?? '';
    const field = h(tag, { id: `columns-${at}`, class: tag === 'textarea' ? 'mono matrix' : 'cell-name', autocomplete: 'off', spellcheck: 'false', 'data-pointer': `/columns/${quantity}/${key}`, ...options, value: tag === 'input' ? shown : null,
      onchange: (e) => { this.kept[quantity][key] = e.target.value; this.changed(); } }, tag === 'textarea' ? shown : null);
    return h('td', {}, h('div', { class: 'field' }, field));
  }

  file(quantity) {
    const now = this.kept[quantity].file ?? '';
    const names = now && !this.files.includes(now) ? [now, ...this.files] : this.files;
    return h('td', {}, h('div', { class: 'field' }, h('select', { class: 'narrow', id: `columns-${quantity}-file`, 'aria-label': `${WORDS[quantity]}: file`, 'data-pointer': `/columns/${quantity}/file`, onchange: (e) => { this.kept[quantity].file = e.target.value; this.changed(); } },
      h('option', { value: '' }, 'this log'), names.map((name) => h('option', { value: name, selected: name === now }, name)))));
  }

  row(quantity) {
    const words = WORDS[quantity];
    const other = this.elsewhere(quantity) ? this.input(quantity, 'headers', 'input', { 'aria-label': `${words}: columns in that file`, placeholder: 'one per joint, …' }) : h('td', { class: 'soft' }, 'as above');
    return h('tr', {}, h('th', { scope: 'row' }, words), this.input(quantity, 'offset', 'input', { 'aria-label': `${words}: offset`, placeholder: '0', 'data-each': 'joint' }),
      this.input(quantity, 'matrix', 'textarea', { 'aria-label': `${words}: matrix`, placeholder: '1 0; 0 1', rows: 1, 'data-each': 'row' }), quantity === 'position' ? h('td', { class: 'soft' }, 'this log') : this.file(quantity), quantity === 'position' ? h('td', { class: 'soft' }, 'as above') : other);
  }

  element(open) {
    const heads = [['Quantity'], ['Offset (rad, m, N·m)', 'column_offset'], ['Matrix', 'column_matrix'], ['File', 'column_file'], ['Columns in that file', 'column_file']];
    return h('details', { id: 'transmissions', open: open ?? this.used }, h('summary', {}, 'Offsets, coupled joints, columns in other files'),
      h('p', { class: 'help field' }, 'Values become matrix · (unit · scale · sign · value) + offset.'),
      h('div', { class: 'field' }, h('span', { class: 'labelled' }, h('label', { for: 'columns-coupling' }, term('column_coupling', 'Coupling of the motors'))), h('textarea', { id: 'columns-coupling', class: 'mono', rows: 2, spellcheck: 'false', placeholder: '1 0 0; 0 1 0; 0 1 1', 'data-pointer': '/columns/coupling', 'data-label': 'Coupling of the motors', 'data-each': 'row',
        onchange: (e) => { this.kept.coupling = e.target.value; this.changed(); } }, this.kept.coupling), h('p', { class: 'help' }, 'Where motors turn several joints: the matrix R of the motors’ positions, p = R q. Rows end with a semicolon or a line.')),
      h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Offsets, matrices and files' }, h('table', { class: 'entry' }, h('thead', {}, h('tr', {}, heads.map(([words, key]) => h('th', { scope: 'col', 'data-own': key ? null : '' }, key ? term(key, words) : words)))), h('tbody', {}, QUANTITIES.map((q) => this.row(q))))));
  }
}
