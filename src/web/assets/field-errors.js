// Errors of the interface at the fields of a form: which field a pointer belongs to, and what the field is called on the page.
import { dotted, h, sentence } from './dom.js';

const CONTROLS = 'input, select, textarea, button';
/** Details that go on from a name: `is 1`, `has 2 values`. All others stand behind a colon. */
const GOES_ON = /^(is|has|must|asks|needs|may|takes|holds|contains|does|cannot)\b/;

/**
 * The field that carries the pointer of an error, or one above it. Of several with one pointer, the last one that somebody filled
 * in.
 */
function fieldOf(form, pointer) {
  const under = (of) => of && (pointer === of || pointer.startsWith(`${of}/`));
  const own = (field) => [field.dataset.pointer, field.dataset.also].filter(under).sort((a, b) => b.length - a.length)[0];
  const fields = [...form.querySelectorAll('[data-pointer]')].filter((f) => own(f) && !f.closest('[hidden]'));
  const filled = (field) => (field.value ? 1 : 0);
  const field = fields.reverse().sort((a, b) => own(b).length - own(a).length || filled(b) - filled(a))[0];
  return field ? { field, rest: pointer.slice(own(field).length).split('/').slice(1) } : null;
}

/** The text of an element without its controls and tags. */
const textOf = (element) => [...element.childNodes].map((n) => (n.nodeType === Node.TEXT_NODE ? n.data : n.nodeType !== Node.ELEMENT_NODE || n.matches(`${CONTROLS}, .tag`) ? '' : textOf(n))).join('').trim();

/**
 * What a field is called on the page, without its unit; nothing where it has no name. `data-label` is for names that are no subject
 * of a sentence.
 */
function nameOf(field) {
  if (field.dataset.label) return field.dataset.label;
  if (field.getAttribute('aria-label')) return field.getAttribute('aria-label');
  const label = textOf(field.labels?.[0] ?? field.querySelector(':scope > legend, :scope > summary, :scope > .label') ?? h('span'));
  const text = label.replace(/ \([^()]*\)$/, '');
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** Counted from 1: the second number of a list for all joints is that of joint 2. */
function placeIn(field, rest) {
  const words = rest.map((part, i) => (!/^\d+$/.test(part) ? part.replaceAll('_', ' ') : `${i === 0 && field.dataset.each ? field.dataset.each : 'entry'} ${Number(part) + 1}`));
  if (!words.length) return '';
  return rest.length === 1 && field.dataset.each ? ` of ${words[0]}` : ` (${words.join(', ')})`;
}

/** The name on the page of what a pointer names; nothing where the page has none. */
export function nameAt(form, pointer) {
  const found = fieldOf(form, pointer);
  const name = found && nameOf(found.field);
  return name ? name + placeIn(found.field, found.rest) : null;
}

/** What a field holds is shown as it was entered: documents call it by its kind. */
function detailAt({ field, rest }, detail) {
  if (field.matches('textarea') && !rest.length) return detail.replace(/^is a string, expected an array/, 'is no list in JSON');
  if (!field.matches('input') || rest.length > 1) return detail;
  const entered = rest.length ? field.value.split(/[\s,;]+/).filter(Boolean)[rest[0]] ?? '' : field.value.trim();
  return detail.replace(/^is a string, expected/, entered ? `is “${entered}”, expected` : 'is empty, expected');
}

/** Angles are in degrees on the page, and numbers of an error those of the document; the number of a joint's name is none. */
const inDegrees = (detail) => detail.replace(/(?<![\w.])-?\d+(\.\d+)?(e-?\d+)?/g, (n) => String(Number(((Number(n) * 180) / Math.PI).toPrecision(7))));
/** Numbers that were computed have more digits than anybody entered. */
const rounded = (detail) => detail.replace(/-?\d+\.\d{7,}/g, (n) => String(Number(Number(n).toPrecision(6))));

/**
 * An error as a person says it: `{name, said, hint, found}`. `name` is that of the field on the page, or null; `said` goes on from
 * it or from the pointer; `found` is the field.
 */
function worded(form, error) {
  const found = form ? fieldOf(form, error.pointer) : null;
  const name = found ? nameAt(form, error.pointer) : null;
  const detail = dotted(found ? detailAt(found, error.detail) : error.detail);
  const angles = /\d/.test(error.detail) && found?.field.dataset.unit;
  const turned = angles && !/\brad\b/.test(`${detail} ${error.hint}`);
  const words = (text) => rounded(turned ? inDegrees(text ?? '') : text ?? '').replace(/`([^`]*)`/g, '“$1”');
  const shown = words(detail);
  const said = name && !GOES_ON.test(detail) ? `: ${shown}` : ` ${shown}`;
  return { ...error, name: name && angles ? `${name} (in ${turned ? '°' : 'rad'})` : name, said: /[.!?]$/.test(said) ? said : `${said}.`, hint: sentence(words(error.hint)), found };
}

/** Puts one error under its field; hands it back in words, with what takes the focus there. */
export function markError(form, error) {
  const { found, ...words } = worded(form, error);
  if (!found) return words;
  const { field } = found;
  for (let part = field.closest('details'); part; part = part.parentElement.closest('details')) part.setAttribute('open', '');
  field.setAttribute('aria-invalid', 'true');
  const id = `error-${Math.random().toString(36).slice(2)}`;
  field.setAttribute('aria-describedby', id);
  // A whole part of the form has its words at its end.
  const place = (said) => (field.closest('.field') ? field.closest('.field').append(said) : field.matches(CONTROLS) ? field.after(said) : field.append(said));
  place(h('p', { class: 'field-error', id }, [words.name ?? error.pointer, words.said, words.hint && ` ${words.hint}`].filter(Boolean).join('')));
  return { ...words, field: field.matches(CONTROLS) ? field : field.querySelector(`${CONTROLS}, summary`) ?? field };
}

/** One line of the summary at the button: the name of the field leads there. */
export function errorLine({ pointer, name, said, hint, field }) {
  const show = () => { field.scrollIntoView({ block: 'center', inline: 'center' }); field.focus(); };
  const called = name ?? h('span', { class: 'mono' }, pointer);
  return h('li', {}, field ? h('button', { type: 'button', class: 'link', onclick: show }, called) : called, said, hint ? h('div', { class: 'soft' }, hint) : null);
}

export function unmark(form) {
  form.querySelectorAll('[aria-invalid]').forEach((f) => f.removeAttribute('aria-invalid'));
  form.querySelectorAll('.field-error').forEach((e) => e.remove());
}

/** What is changed is no longer what was refused: its mark goes, and those of the part of the form that it switches. */
export function unmarkAround(field) {
  const around = field.closest('details') ?? field.closest('.field');
  if (around) unmark(around);
}

/** A description is asked for as a part of another request: what is said of that is said of the description. */
export function described(error) {
  const count = error.problem?.errors?.filter((e) => e.pointer.startsWith('/robot')).length;
  return count ? Object.assign(error, { problem: { ...error.problem, detail: `The description has ${count} problem${count > 1 ? 's' : ''}` } }) : error;
}
