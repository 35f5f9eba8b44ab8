// Columns of a log that are further quantities, such as a temperature: each has a name for formulas and a unit.
import { h } from './dom.js';

/** What a column is used as where it is one. */
export const CHANNEL = 'channel';
/** What its words suggest of its unit. */
const KINDS = [[/temp|(^|_)t(_|$)|degc|celsius/, 'degC'], [/press|pa$/, 'Pa'], [/current|_i$|amp/, 'A'], [/volt|_u$/, 'V'], [/force/, 'N']];
/** Units that formulas know. */
const UNITS = ['1', 'degC', 'K', 'A', 'V', 'W', 'Pa', 'N', 'N m', 'm', 'm/s', 'rad', 'rad/s', 's', 'Hz', 'kg'];

export class LogChannels {
  /** `changed` is called when a name or a unit has changed. */
  constructor(changed) {
    Object.assign(this, { changed, list: [] });
  }

  of(header) {
    return this.list.find((c) => c.header === header);
  }

  /** The column becomes a quantity with the name that its header suggests, or is one no more. */
  set({ name: header, unit }, is) {
    const had = this.of(header);
    if (is && !had) this.list.push({ header, name: this.free(nameOf(header)), unit: UNITS.includes(unit) ? unit : KINDS.find(([words]) => words.test(header.toLowerCase()))?.[1] ?? '1' });
    if (!is && had) this.list.splice(this.list.indexOf(had), 1);
  }

  free(name) {
    const taken = this.list.map((c) => c.name);
    return [name, ...taken.map((_, k) => `${name}_${k + 2}`)].find((n) => !taken.includes(n));
  }

  /** `columns.channels` of a request. */
  value() {
    return this.list.length ? this.list.map(({ header, name, unit }) => ({ name, header, unit: unit || undefined })) : undefined;
  }

  /** Name and unit of a column, to be changed. */
  inputs(header) {
    const at = this.list.indexOf(this.of(header));
    const input = (key, words, options) => h('input', { class: 'cell-name', id: `channel-${at}-${key}`, value: this.list[at][key], 'aria-label': `${header}: ${words}`, 'data-pointer': `/columns/channels/${at}/${key}`, autocomplete: 'off', spellcheck: 'false', ...options,
      onchange: (e) => { this.list[at][key] = e.target.value.trim(); this.changed(); } });
    // What is wrong with one stands below both.
    return h('div', { class: 'field' }, h('div', { class: 'row', style: 'flex-wrap:nowrap' }, input('name', 'name in formulas'), input('unit', 'unit', { class: 'cell-number', list: 'channel-units' })));
  }

  /** Units to choose from, once per table. */
  units() {
    return h('datalist', { id: 'channel-units' }, UNITS.map((value) => h('option', { value })));
  }
}

/** A header as a name in formulas: letters, digits and `_`. */
function nameOf(header) {
  const name = header.replace(/[^A-Za-z0-9]+/g, '_').replace(/^_+|_+$/g, '');
  return /^[A-Za-z]/.test(name) ? name.slice(0, 60) : `x_${name}`.slice(0, 60);
}
