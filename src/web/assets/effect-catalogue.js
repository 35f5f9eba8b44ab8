// The lab's catalogue of own effects.
import { Refused, getJson, postJson, send } from './api.js';
import { formula } from './expression.js';
import { fill, h, sentence } from './dom.js';

/** Milliseconds without a key that are a pause in writing: half a name would be refused. */
export const PAUSE = 700;

export const catalogue = async () => (await getJson('/effects')).effects;

/** Keeps a definition under its name, in the place of the one that had it. */
export async function keep(definition) {
  if (!definition.name) throw new Refused({ detail: 'The effect has no name.', errors: [{ pointer: '/name', detail: 'is missing', hint: 'requests and robots use it by this name' }] });
  return send(`/effects/${encodeURIComponent(definition.name)}`, { method: 'PUT', headers: { 'content-type': 'application/json' }, body: JSON.stringify(definition) });
}

export const forget = (name) => send(`/effects/${encodeURIComponent(name)}`, { method: 'DELETE' });

/** The formula as browsers set it, fractions in full size; its text where it cannot be set. */
export function typeset({ mathml, definition }) {
  const set = mathml ? formula(mathml) : null;
  set?.setAttribute('displaystyle', 'true');
  return set ?? h('span', { class: 'mono' }, definition.expression);
}

/** Where a formula stands: a long one is scrolled. */
export const formulaPlace = (...content) => h('div', { class: 'formula', tabindex: 0, role: 'group', 'aria-label': 'Formula' }, content);

/** What a definition lacks that somebody is still writing, in words; nothing where the server can judge it. */
export function unfinished({ expression, parameters = [], channels = [] }) {
  const text = expression.trim();
  const count = (sign) => text.split(sign).length - 1;
  if (!text) return 'No formula yet.';
  if (count('(') > count(')')) return 'A parenthesis is still open.';
  if (/[-+*/^(,]$/.test(text) || /\(\s*\)/.test(text)) return 'The formula is not complete yet.';
  const bare = [...parameters, ...channels].some((p) => !p.name.trim() || !p.unit.trim());
  return bare ? 'A parameter or quantity has no name or unit yet.' : null;
}

/** Shows a definition as a formula at `place` a moment after it was last changed, or the first thing that is wrong with it. */
export class Preview {
  /** `nameAt(pointer)`: what a field of the definition is called on the page. */
  constructor(definition, nameAt) {
    Object.assign(this, { definition, nameAt, place: formulaPlace(), asked: 0, waiting: null });
    this.show();
  }

  soon() {
    clearTimeout(this.waiting);
    // A form that was drawn anew has another preview.
    this.waiting = setTimeout(() => this.place.isConnected && this.show(), PAUSE);
  }

  async show() {
    this.asked += 1;
    const { asked } = this;
    // Its name does not change how it is set.
    const definition = { ...this.definition(), name: 'preview' };
    const lacks = unfinished(definition);
    const shown = lacks ? soft(lacks) : await postJson('/effect-preview', definition).then(typeset, (error) => soft(this.wrong(error)));
    if (asked === this.asked) fill(this.place, shown);
  }

  /** The first thing that is wrong; of the formula itself without its name, which stands above. */
  wrong({ problem }) {
    const [first] = problem?.errors ?? [];
    if (!first) return problem?.detail ?? 'The formula cannot be shown.';
    return sentence(first.pointer === '/expression' ? first.detail : `${this.nameAt(first.pointer) ?? first.pointer} ${first.detail}`).replace(/`([^`]*)`/g, '“$1”');
  }
}

const soft = (text) => h('span', { class: 'soft' }, text);

