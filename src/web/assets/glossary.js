// Help on terms: one glossary, read when a term is first asked for. A term is a button, so that mouse, touch and keyboard reach it.
import { h, term } from './dom.js';

/** Terms of the pages, and those of effects as the program has them. */
const FILES = ['/assets/glossary.json', '/assets/effects.json'];
/** Milliseconds that the pointer rests before help opens, and that it has to reach the help before that closes. */
const REST = 250;
/** Pixels between help, its term, and the edges of the window. */
const GAP = 8;

let reading = null;
function topics() {
  reading ??= Promise.all(FILES.map(async (file) => (await fetch(file)).json())).then((parts) => parts.flat());
  return reading;
}

/** All terms by key: {name, text, topic, part}; `part` is the section of the help page on their topic. */
export const glossary = async () => new Map((await topics()).flatMap(({ topic, part, terms }) => Object.entries(terms).map(([key, [name, text]]) => [key, { name, text, topic, part }])));

/** Phrases of the interface that are terms, the longest first: one expression, and the key of each. */
let phrases = null;
function mentioned() {
  phrases ??= topics().then((all) => {
    const keys = new Map(all.flatMap(({ mentions, aliases = {}, terms }) => [...Object.entries(aliases), ...(mentions ? Object.entries(terms).map(([key, [name]]) => [name.toLowerCase(), key]) : [])]));
    const longest = [...keys.keys()].sort((a, b) => b.length - a.length);
    return { keys, all: new RegExp(`(?<![\\w-])(${longest.join('|')})(?![\\w-])`, 'gi') };
  });
  return phrases;
}

/** Makes the first mention of every term in a text a button with its help. */
export async function mention(place) {
  const { keys, all } = await mentioned();
  const text = place.textContent;
  const seen = new Set();
  const parts = [];
  let from = 0;
  for (const found of text.matchAll(all)) {
    const key = keys.get(found[0].toLowerCase());
    if (seen.has(key)) continue;
    seen.add(key);
    // Brackets and stops stay on the line of the term.
    const [open] = /\S*$/.exec(text.slice(from, found.index));
    const end = found.index + found[0].length;
    const [close] = /^[^\s\w]*/.exec(text.slice(end));
    parts.push(text.slice(from, found.index - open.length), h('span', open || close ? { class: 'nowrap' } : {}, open, term(key, found[0]), close));
    from = end + close.length;
  }
  if (parts.length) place.replaceChildren(...parts, text.slice(from));
}

let open = null;
let timer = null;

function close() {
  clearTimeout(timer);
  if (!open) return;
  open.button.setAttribute('aria-expanded', 'false');
  open.button.removeAttribute('aria-describedby');
  open.box.remove();
  open = null;
}

async function show(button, pinned) {
  clearTimeout(timer);
  if (open?.button === button) {
    open.pinned ||= pinned;
    return;
  }
  const entry = (await glossary()).get(button.dataset.term);
  close();
  if (!entry || !button.isConnected) return;
  // Spans: a term may stand in a paragraph or a heading.
  const box = h('span', { id: 'term-help', class: 'term-help', popover: 'manual' }, h('strong', {}, entry.name), h('span', {}, entry.text), h('a', { href: `/help#${entry.part}` }, 'How it works'));
  button.after(box);
  box.showPopover();
  place(box, button.getBoundingClientRect());
  button.setAttribute('aria-expanded', 'true');
  button.setAttribute('aria-describedby', 'term-help');
  open = { button, box, pinned };
}

/** Below the term, above it where there is no room, and within the window. */
function place(box, at) {
  const { width, height } = box.getBoundingClientRect();
  const left = Math.max(GAP, Math.min(at.left, document.documentElement.clientWidth - width - GAP));
  const below = at.bottom + GAP + height <= innerHeight || at.top < height + GAP;
  Object.assign(box.style, { left: `${left}px`, top: `${below ? at.bottom + GAP / 2 : at.top - height - GAP / 2}px` });
}

const termOf = (event) => event.target.closest?.('[data-term]');
const inside = (event) => event.target.closest?.('#term-help');

document.addEventListener('click', (event) => {
  const button = termOf(event);
  if (button) {
    // In a summary or a head that sorts, a term opens its help and nothing else.
    event.preventDefault();
    event.stopPropagation();
    if (open?.button === button && open.pinned) close();
    else show(button, true);
  } else if (!inside(event)) close();
}, { capture: true });
document.addEventListener('pointerover', (event) => {
  if (event.pointerType !== 'mouse') return;
  const button = termOf(event);
  if (!button && !inside(event)) return;
  clearTimeout(timer);
  if (button) timer = setTimeout(() => show(button, false), REST);
});
document.addEventListener('pointerout', (event) => {
  if (event.pointerType !== 'mouse' || !(termOf(event) || inside(event))) return;
  clearTimeout(timer);
  if (open && !open.pinned) timer = setTimeout(close, REST);
});
document.addEventListener('keydown', (event) => event.key === 'Escape' && close());
document.addEventListener('focusin', (event) => open && event.target !== open.button && !inside(event) && close());
addEventListener('scroll', (event) => !(event.target instanceof Element && event.target.closest('#term-help')) && close(), { capture: true, passive: true });
addEventListener('resize', close);
