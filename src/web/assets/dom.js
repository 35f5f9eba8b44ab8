// Elements, numbers and words.

/** An element: `h('p', {class: 'soft', onclick: f}, 'text', child)`. Text is text: nothing is ever read as HTML. */
export function h(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.flat(Infinity).filter((c) => c !== null && c !== undefined && c !== false));
  return element;
}

export const find = (selector, within = document) => within.querySelector(selector);

export function fill(element, ...children) {
  element.replaceChildren(...children.flat(Infinity).filter((c) => c !== null && c !== undefined && c !== false));
  return element;
}

/** A number to `digits` significant digits, without exponents for sizes that people read. */
export function number(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(Math.max(digits - 1, 0)).replace(/^-/, '−').replace('e', ' · 10^').replace(/\^\+?(-?)(\d+)/, (_, s, d) => superscript(s + d));
  return String(Number(value.toPrecision(digits))).replace('-', '−');
}

/** `value ± deviation` to the second digit of the deviation; the value alone where it was given and has none. */
export function measured(value, deviation) {
  if (deviation === 0) return number(value, 3);
  const decimals = 1 - Math.floor(Math.log10(deviation));
  if (!(deviation > 0) || decimals > 8 || Math.abs(value) >= 1e6) return `${number(value, 3)} ± ${number(deviation, 2)}`;
  const fixed = (v) => v.toFixed(Math.max(decimals, 0)).replace('-', '−');
  return `${fixed(value)} ± ${fixed(deviation)}`;
}

const superscript = (text) => [...text].map((c) => '⁰¹²³⁴⁵⁶⁷⁸⁹'['0123456789'.indexOf(c)] ?? '⁻').join('');

/** Units as people write them: `kg m^2` → `kg·m²`. */
export const unit = (text) => (text ?? '').replaceAll(' ', '·').replaceAll('^2', '²').replaceAll('^3', '³');

export const perSecond = (positionUnit, times) => unit(positionUnit) + ['', '/s', '/s²', '/s³'][times];

export function time(text) {
  const then = new Date(text);
  const today = then.toDateString() === new Date().toDateString();
  const clock = then.toLocaleTimeString([], { hour: '2-digit', minute: '2-digit' });
  return today ? clock : `${then.toLocaleDateString([], { day: 'numeric', month: 'short' })} ${clock}`;
}

/** Names longer than this crowd an axis. */
const LONG = 10;
/** Names for places with little room: `left_arm_elbow_joint` beside `left_arm_wrist_joint` is `elbow`. */
export function shortNames(names) {
  if (names.length < 2 || names.every((name) => name.length <= LONG)) return names;
  const parts = names.map((name) => name.split(/(?<=[_\-. /])/));
  const least = Math.min(...parts.map((p) => p.length)) - 1;
  const alike = (at) => parts.every((p) => p.at(at) === parts[0].at(at));
  let [front, back] = [0, 0];
  while (front < least && alike(front)) front += 1;
  while (back < least - front && alike(-1 - back)) back += 1;
  return parts.map((p) => p.slice(front, p.length - back).join('').replace(/[_\-. /]$/, ''));
}

/** A name that a narrow column breaks after its parts: `panda_` `joint1`. */
export const breakable = (name) => name.split(/(?<=[_\-./])/).flatMap((part, i) => (i ? [h('wbr'), part] : [part]));

/** Controllers count from their own start, or from 1970: series are drawn from the first sample. */
export const sinceStart = (time) => time.map((t) => t - time[0]);

export function seconds(value) {
  if (value < 90) return `${number(value, value < 10 ? 2 : 3)} s`;
  return `${Math.floor(value / 60)} min ${Math.round(value % 60)} s`;
}

/** Names of fields are spelt as in America, pages as in Britain. */
const centred = (text) => text.replace(/\bcenter\b/g, 'centre').replace(/\bload dependent\b/g, 'load-dependent').replace(/`([^`]*)`/g, '“$1”');

/** `stribeck_friction` → `Stribeck friction`, `BudgetExhausted` → `Budget exhausted`. */
export function words(code) {
  const text = centred((code ?? '').replaceAll('_', ' ').replace(/([a-z])([A-Z])/g, (_, a, b) => `${a} ${b.toLowerCase()}`));
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** What the interface says in half a sentence, as one; a name of a file at its beginning stays as it is. */
export const sentence = (text) => (text ? `${/^\S+\.\w+/.test(text) ? text.charAt(0) : text.charAt(0).toUpperCase()}${dotted(text.slice(1))}${/[.!?]$/.test(text) ? '' : '.'}` : '');

/** Units of the interface within a text, as people write them. */
export const dotted = (text) => text.replace(/\bN m\b/g, 'N·m');

/** What a request would say, where the page has a place for it. */
const onThePage = (text) => text.replace(/set “sign” to -1 in “columns”/g, 'choose “inverted” under “Scale and sign”');

/** A text of the interface: terms in it get help on their first mention. */
export function said(text) {
  const place = h('span', {}, onThePage(centred(text ?? '')));
  if (text) import('./glossary.js').then((help) => help.mention(place));
  return place;
}

/** Twice the log of odds, as odds. */
export const odds = (evidence) => (evidence > 40 ? 'beyond doubt' : `odds of ${number(Math.exp(evidence / 2), 2)} to 1`);

/** A technical term with help from the glossary (`glossary.json`, by `key`). */
export const term = (key, label) => h('button', { type: 'button', class: 'term', 'data-term': key, 'aria-expanded': 'false' }, label);

/** The same beside a label or a head that is a control itself. */
export const mark = (key, label) => h('button', { type: 'button', class: 'term mark', 'data-term': key, 'aria-expanded': 'false', 'aria-label': `Explain: ${label}` }, '?');

/** The label of the field `id`, with help on the term `key`. */
export const labelled = (text, id, key) => h('span', { class: 'labelled' }, h('label', { for: id }, text), mark(key, text));

/** A key figure: name over value. */
export const figure = (name, value, note) =>
  h('div', { class: 'figure' }, h('dt', {}, name), h('dd', {}, value, note ? [' ', h('small', {}, note)] : null));

/** Rows of a table beyond which it has a height of its own: on a phone two ways to scroll are in each other's way. */
const MANY = 12;

/** A table that sorts by its heads. `columns`: {head, cell(row), sort(row), number, term, hidden, own}; `term`: key in the glossary; `own`: the head is a name that the user gave. */
export function table(columns, rows, { caption, sort } = {}) {
  const body = h('tbody');
  const show = (list) => fill(body, list.map((row) => h('tr', {}, columns.map((c) => h('td', { class: c.number ? 'number' : null }, c.cell(row))))));
  const heads = columns.map((column) => {
    const head = h('th', { scope: 'col', class: column.number ? 'number' : null, 'data-own': column.own });
    if (column.sort) head.append(h('button', { type: 'button', class: 'sort', onclick: () => order(column, head) }, column.head), column.term ? mark(column.term, column.head) : '');
    else head.append(column.hidden ? h('span', { class: 'unseen' }, column.head) : column.term ? term(column.term, column.head) : column.head);
    return head;
  });
  function order(column, head, direction) {
    const way = direction ?? (head.getAttribute('aria-sort') === 'ascending' ? 'descending' : 'ascending');
    heads.forEach((other) => other.removeAttribute('aria-sort'));
    head.setAttribute('aria-sort', way);
    const sign = way === 'ascending' ? 1 : -1;
    const last = (v) => v === null || v === undefined || Number.isNaN(v);
    show([...rows].sort((a, b) => {
      const [x, y] = [column.sort(a), column.sort(b)];
      if (last(x) || last(y)) return last(x) - last(y);
      return sign * (typeof x === 'string' ? x.localeCompare(y, undefined, { numeric: true }) : x - y);
    }));
  }
  show(rows);
  if (sort) order(columns[sort.column], heads[sort.column], sort.way);
  return h('div', { class: rows.length > MANY ? 'scroll tall' : 'scroll', tabindex: 0, role: 'region', 'aria-label': caption ?? 'Table' },
    h('table', { class: columns.length <= 3 ? 'few' : null }, caption ? h('caption', {}, h('span', {}, caption)) : null, h('thead', {}, h('tr', {}, heads)), body));
}
