// Help on terms: one glossary, read when a term is first asked for. A term is a button, so that mouse, touch and keyboard reach it.
import { h } from './dom.js';

/** Milliseconds that the pointer rests before help opens, and that it has to reach the help before that closes. */
const REST = 250;
/** Pixels between help, its term, and the edges of the window. */
const GAP = 8;

let reading = null;
/** All terms by key: {name, text, topic, part}; `part` is the section of the help page on their topic. */
export function glossary() {
  reading ??= fetch('/assets/glossary.json').then((answer) => answer.json()).then((topics) => new Map(topics.flatMap(({ topic, part, terms }) => Object.entries(terms).map(([key, [name, text]]) => [key, { name, text, topic, part }]))));
  return reading;
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
