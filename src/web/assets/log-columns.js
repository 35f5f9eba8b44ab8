// Which column of a log is what, and what will be done to it: a table with a drop-down and a small picture of each series.
import { breakable, fill, find, h, number, term } from './dom.js';
import { CHANNEL, LogChannels } from './log-channels.js';
import { guess, units } from './log-guess.js';
import { LogTransmissions } from './log-transmissions.js';

const UNITS = { position: ['rad', 'deg', 'rev', 'm', 'mm'], velocity: ['rad/s', 'deg/s', 'rpm', 'm/s', 'mm/s'], torque: ['N m', 'mN m', 'kN m', 'N', 'kN', 'A'], time: ['s', 'ms', 'us', 'ns'] };
const SHOWN = { 'N m': 'N·m', 'mN m': 'mN·m', 'kN m': 'kN·m', us: 'µs' };
const QUANTITIES = ['position', 'torque', 'velocity'];
const STANDARD = { time: /^(time|t)$/i, position: /^q\d+$/i, velocity: /^qd\d+$/i, torque: /^tau\d+$/i };

/** Letters of a name that needs a wide column. */
const LONG = 14;

/** Heads that are terms. */
const HEADS = { 'Used as': 'column_use', 'Scale and sign': 'column_scale', Becomes: 'column_unit' };

const perQuantity = () => Object.fromEntries(QUANTITIES.map((q) => [q, { scale: [], sign: [] }]));

export class LogColumns {
  /** `changed` is called when the mapping has changed. */
  constructor(place, changed) {
    Object.assign(this, { place, changed, head: null, joints: [], roles: new Map(), units: {}, factors: perQuantity(), touched: false, channels: new LogChannels(() => this.change()), further: new LogTransmissions(() => this.change()) });
  }

  /** Shows the columns of a log for a robot {id, joints}; remembers what was chosen for logs with these columns before. `files`: names of further logs. */
  show(head, robot, { files = [] } = {}) {
    Object.assign(this, { head, robot, joints: robot.joints, factors: perQuantity(), touched: false, rate: '', scaleTrouble: '', channels: new LogChannels(() => this.change()) });
    const found = guess(head.columns, robot.joints);
    this.preset = found.preset;
    this.count = found.count;
    this.units = units(head.columns, found);
    this.roles = new Map();
    if (found.time) this.roles.set(found.time, 'time');
    QUANTITIES.forEach((q) => found[q]?.forEach((name, j) => this.roles.set(name, `${q} ${j}`)));
    const kept = JSON.parse(localStorage.getItem(this.key()) ?? 'null');
    if (kept) Object.assign(this, { units: kept.units, factors: { ...perQuantity(), ...kept.factors }, rate: kept.rate ?? '', roles: new Map(kept.roles), touched: true, preset: 'as last time for this robot' });
    this.channels.list = kept?.channels ?? [];
    this.further.set(kept?.further, files);
    this.draw();
  }

  clear() {
    this.head = null;
    fill(this.place);
  }

  key() {
    return `dynident.columns.${this.robot.id}.${this.head.columns.map((c) => c.name).join('|').slice(0, 400)}`;
  }

  keep() {
    if (!this.touched) return;
    localStorage.setItem(this.key(), JSON.stringify({ roles: [...this.roles], units: this.units, factors: this.factors, rate: this.rate, channels: this.channels.list, further: this.further.kept }));
  }

  named(quantity) {
    return this.joints.map((_, j) => [...this.roles].find(([, role]) => role === `${quantity} ${j}`)?.[0]);
  }

  /** What is missing before the log can be read, in words. */
  missing() {
    const joints = (quantity) => this.joints.filter((_, j) => !this.named(quantity)[j]);
    const lacks = ['position', 'torque'].map((q) => [q, joints(q)]).filter(([q, list]) => list.length && !this.further.elsewhere(q));
    const words = lacks.map(([q, list]) => `no ${q} for ${list.length === this.joints.length ? 'any joint' : list.join(', ')}`);
    if (!this.time() && !(Number(this.rate) > 0)) words.push('no time; give the sample rate instead');
    const without = this.units.torque === 'A' ? this.joints.filter((_, j) => this.named('torque')[j] && this.factors.torque.scale[j] === undefined) : [];
    if (without.length) words.push(`no N·m per ampere for ${without.length === this.joints.length ? 'any joint' : without.join(', ')}`);
    return words;
  }

  /** A log whose names count other joints than the robot has is most often of another robot. */
  otherArm() {
    const { count, joints } = this;
    return count > 1 && count !== joints.length && !this.named('position').some(Boolean) ? ` By its names the log is of an arm with ${count} joints, and ${this.robot.name ?? 'the robot'} has ${joints.length}: is it the right robot?` : '';
  }

  time() {
    return [...this.roles].find(([, role]) => role === 'time')?.[0];
  }

  /** `columns` of a request; nothing where the usual names say it all. */
  value() {
    if (!this.head) return undefined;
    const standard = !this.touched && [...this.roles].every(([name, role]) => STANDARD[role.split(' ')[0]].test(name)) && this.units.position === 'rad' && this.units.torque === 'N m' && this.units.time === 's';
    if (standard) return undefined;
    const all = (list, whole) => (list.some((v) => v !== undefined && v !== whole) ? this.joints.map((_, j) => list[j] ?? whole) : undefined);
    const velocity = this.named('velocity').every(Boolean) || this.further.elsewhere('velocity');
    const quantity = (q, si) => ({ headers: this.named(q), unit: this.units[q] === si ? undefined : this.units[q], scale: all(this.factors[q].scale, 1), sign: all(this.factors[q].sign, 1), ...this.further.of(q) });
    return {
      time: this.time(), time_unit: this.time() && this.units.time !== 's' ? this.units.time : undefined, sample_rate_hz: Number(this.rate) > 0 ? Number(this.rate) : undefined,
      position: quantity('position', 'rad'), velocity: velocity ? quantity('velocity', 'rad/s') : undefined, torque: quantity('torque', 'N m'), coupling: this.further.coupling(),
      channels: this.channels.value(),
    };
  }

  change() {
    this.touched = true;
    this.keep();
    // What takes the focus has it when the table is drawn anew.
    setTimeout(() => this.head && this.draw());
    this.changed();
  }

  draw() {
    const { head } = this;
    const focused = this.place.contains(document.activeElement) ? document.activeElement : null;
    const open = find('#transmissions', this.place)?.open;
    const used = head.columns.filter((c) => this.roles.has(c.name));
    const rest = head.columns.filter((c) => !this.roles.has(c.name));
    const missing = this.missing();
    const unit = (quantity, words) => h('label', { class: 'inline' }, words, h('select', { class: 'narrow', id: `unit-${quantity}`, 'data-pointer': quantity === 'time' ? '/columns/time_unit' : `/columns/${quantity}/unit`, 'data-label': `Unit of ${quantity}`, onchange: (e) => { this.units[quantity] = e.target.value; this.change(); } },
      UNITS[quantity].map((u) => h('option', { value: u, selected: this.units[quantity] === u }, SHOWN[u] ?? u))));
    fill(this.place, h('section', { class: 'card', id: 'columns', 'aria-labelledby': 'columns-title' }, h('div', { class: 'row spread' }, h('h2', { id: 'columns-title' }, `Columns of ${head.file}`), this.preset ? h('span', { class: 'tag good' }, this.preset) : null),
      missing.length ? h('div', { class: 'notice', role: 'status' }, h('p', {}, h('strong', {}, 'Assign the columns: '), missing.join('; '), '.', this.otherArm())) : null,
      h('div', { class: 'row field' }, h('span', {}, term('column_unit', 'Units'), ':'), this.time() ? unit('time', 'time in') : null, unit('position', 'positions in'), this.named('velocity').some(Boolean) ? unit('velocity', 'velocities in') : null, unit('torque', 'torques in'),
        this.time() ? null : h('label', { class: 'inline' }, 'sample rate (Hz)', h('input', { class: 'cell-number', id: 'columns-rate', inputmode: 'decimal', value: this.rate, 'data-pointer': '/columns/sample_rate_hz', onchange: (e) => { this.rate = e.target.value; this.change(); } }))),
      this.units.torque === 'A' ? h('div', { class: this.factors.torque.scale.length ? 'field' : 'notice' }, h('p', {}, 'Currents become torques by ', term('torque_constant', 'N·m per ampere'), ' at the joint: torque constant × gear ratio. Enter it for every joint below, or all at once: ', h('input', { class: 'cell-number', id: 'scale-all', 'aria-label': 'N·m per ampere of all joints', placeholder: '8.5, 8.5, …', autocomplete: 'off', onchange: (e) => this.scaleAll(e.target.value) })), this.scaleTrouble ? h('p', { class: 'field-error', role: 'alert' }, this.scaleTrouble) : null) : null,
      this.table(used, 'Columns that are used'), h('details', { open: missing.length > 0 && rest.length < 60 }, h('summary', {}, `Columns that are not used (${rest.length})`), rest.length ? this.table(rest, 'Columns that are not used') : null), this.further.element(open), this.channels.units()));
    const again = focused?.id && document.getElementById(focused.id);
    if (!again) return;
    // Somebody is typing there already.
    if (focused.matches('input, textarea')) again.value = focused.value;
    again.focus();
  }

  table(columns, label) {
    const heads = ['Column', 'Used as', 'Series', 'Scale and sign', 'Becomes', 'First values'];
    return h('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': label }, h('table', { class: 'entry' }, h('thead', {}, h('tr', {}, heads.map((t) => h('th', { scope: 'col' }, HEADS[t] ? term(HEADS[t], t) : t)))),
      h('tbody', {}, columns.map((c) => h('tr', {}, h('th', { scope: 'row', class: c.name.length > LONG ? 'mono long' : 'mono' }, breakable(c.name)), h('td', {}, this.role(c)), h('td', {}, spark(c)), h('td', {}, this.factor(c)), h('td', { class: 'soft' }, this.becomes(c)), h('td', { class: 'mono soft nowrap' }, c.shown.map(brief).join('  ')))))));
  }

  role(column) {
    const now = this.roles.get(column.name) ?? '';
    const option = (value, words) => h('option', { value, selected: value === now }, words);
    const select = h('select', { class: 'narrow', id: `role-${column.at}`, 'aria-label': `${column.name}: used as`, disabled: !column.numeric, onchange: () => {
      // A place has one column: the one that had it before is free again. Further quantities are as many as there are.
      for (const [name, role] of this.roles) if (role === select.value && role !== CHANNEL) this.roles.delete(name);
      this.channels.set(column, select.value === CHANNEL);
      if (select.value) this.roles.set(column.name, select.value);
      else this.roles.delete(column.name);
      this.change();
    } }, option('', column.numeric ? 'not used' : 'text, not used'), option('time', 'time'), QUANTITIES.map((q) => h('optgroup', { label: q }, this.joints.map((j, at) => option(`${q} ${at}`, `${q} ${j}`)))), option(CHANNEL, 'further quantity'));
    return select;
  }

  factor(column) {
    const [quantity, at] = (this.roles.get(column.name) ?? '').split(' ');
    if (quantity === CHANNEL) return this.channels.inputs(column.name);
    if (!this.factors[quantity]) return null;
    const { scale, sign } = this.factors[quantity];
    const j = Number(at);
    // What is no number goes to the server as it is, which says so at the field.
    const entered = (text) => (text.trim() === '' ? undefined : Number.isFinite(Number(text.replace(',', '.'))) ? Number(text.replace(',', '.')) : text);
    const field = (key) => ({ id: quantity === 'torque' ? `${key}-${j}` : `${key}-${quantity}-${j}`, 'aria-label': `${column.name}: ${key}`, 'data-pointer': `/columns/${quantity}/${key}/${j}`, 'data-also': `/columns/${quantity}/${key}` });
    return h('div', { class: 'field' }, h('div', { class: 'row', style: 'flex-wrap:nowrap' }, h('input', { class: 'cell-number', ...field('scale'), inputmode: 'decimal', value: scale[j] ?? '', placeholder: quantity === 'torque' && this.units.torque === 'A' ? 'N·m/A' : '1', onchange: (e) => { scale[j] = entered(e.target.value); this.change(); } }),
      h('select', { class: 'narrow', ...field('sign'), onchange: (e) => { sign[j] = Number(e.target.value); this.change(); } }, [[1, 'as it is'], [-1, 'inverted']].map(([v, t]) => h('option', { value: v, selected: (sign[j] ?? 1) === v }, t)))));
  }

  /** One number for all joints, or one per joint, separated by spaces, commas or semicolons. */
  scaleAll(text) {
    const list = text.replaceAll('−', '-').split(/[\s,;]+/).filter(Boolean).map(Number);
    const usable = list.every(Number.isFinite) && [1, this.joints.length].includes(list.length);
    this.scaleTrouble = usable || !text.trim() ? '' : `N·m per ampere is “${text.trim()}”, expected one number, or ${this.joints.length} for the ${this.joints.length} joints.`;
    if (!usable) return this.draw();
    this.factors.torque.scale = this.joints.map((_, j) => list[j] ?? list[0]);
    return this.change();
  }

  becomes(column) {
    const role = this.roles.get(column.name);
    if (!role) return '';
    if (role === 'time') return `time${this.units.time === 's' ? '' : `, from ${SHOWN[this.units.time] ?? this.units.time} to s`}`;
    if (role === CHANNEL) return `${this.channels.of(column.name).name} (${this.channels.of(column.name).unit || '1'})`;
    const [quantity, at] = role.split(' ');
    const si = { position: ['rad', 'm'], velocity: ['rad/s', 'm/s'], torque: ['N m', 'N'] }[quantity];
    const unit = this.units[quantity];
    const factor = (this.factors[quantity].scale[at] ?? 1) * (this.factors[quantity].sign[at] ?? 1);
    const scaled = factor === 1 ? '' : `, × ${number(factor)}`;
    return `${quantity} of ${this.joints[at]}${scaled}${si.includes(unit) ? '' : `, from ${SHOWN[unit] ?? unit}`}`;
  }
}

/** A value of the file, short enough for a table: small ones are rounded to three digits. */
const short = (value) => (value !== 0 && Math.abs(value) < 1e-3 ? value.toExponential(2) : String(Number(value.toPrecision(6))));
const brief = (text) => (Number.isFinite(Number(text)) && (text.length > 9 || Math.abs(Number(text)) < 1e-3) ? short(Number(text)) : text.slice(0, 20));

/** A series as a small picture. */
function spark({ points, name, numeric }) {
  const finite = points.filter(Number.isFinite);
  if (!numeric || finite.length < 2) return '–';
  const [low, high] = [Math.min(...finite), Math.max(...finite)];
  if (low === high) return h('span', { class: 'soft nowrap' }, `constant ${number(low, 3)}`);
  const place = (v, i) => `${((i / (points.length - 1)) * 96 + 2).toFixed(1)},${(22 - ((v - low) / (high - low)) * 20).toFixed(1)}`;
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  Object.entries({ viewBox: '0 0 100 24', width: 100, height: 24, class: 'spark', role: 'img', 'aria-label': `${name}: from ${number(low, 3)} to ${number(high, 3)}` }).forEach(([k, v]) => svg.setAttribute(k, v));
  const line = document.createElementNS('http://www.w3.org/2000/svg', 'polyline');
  line.setAttribute('points', points.map((v, i) => (Number.isFinite(v) ? place(v, i) : null)).filter(Boolean).join(' '));
  svg.append(line);
  return h('span', { title: `${number(low, 3)} … ${number(high, 3)}` }, svg);
}
