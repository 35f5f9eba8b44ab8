// Expressions of base parameters as formulas: `MY2 + 0.42 (M3 + M4)` with indices below and names in italics.
import { h } from './dom.js';

export function typeset(text) {
  if (/constant torque/.test(text)) return text;
  const parts = text.match(/[A-Z]+[A-Z]*\d+|\d+(?:\.\d+)?(?:e[-+]?\d+)?(?:\^\d+)?|\^\d+|[^A-Z\d^]+|./g) ?? [];
  return h('span', { class: 'expression' }, parts.map((part) => {
    const name = /^([A-Z]+)(\d+)$/.exec(part);
    if (name) return symbol(name[1], name[2]);
    const power = /^(.*)\^(\d+)$/.exec(part);
    if (power) return [power[1], h('sup', {}, power[2])];
    return part.replaceAll('-', '−').replaceAll('*', '·');
  }));
}

/** `MY`, `2` → m·y with the link below, as in the literature: MY₂. */
export const symbol = (name, index) => h('span', {}, h('i', {}, name), h('sub', {}, index));
