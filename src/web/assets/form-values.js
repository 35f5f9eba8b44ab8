// What inputs hold, as documents have it. What is no number goes to the server as it is, which says so at the field.
import { find } from './dom.js';

export const value = (id) => find(`#${id}`).value.trim();
export const numeric = (text) => (text === '' ? undefined : Number.isFinite(Number(text)) ? Number(text) : text);
export const list = (text) => (text ? text.replaceAll('−', '-').split(/[\s,;]+/).filter(Boolean).map(numeric) : undefined);
/** Undefined where nothing is given. */
export const some = (object) => (Object.values(object).some((v) => v !== undefined) ? object : undefined);

/** `1-5; 1-3, 7` → one list per joint. */
export function harmonics(text) {
  if (!text) return undefined;
  const range = (part) => {
    const [, from, to] = /^(\d+)[-–](\d+)$/.exec(part) ?? [];
    return from ? Array.from({ length: Math.max(to - from + 1, 0) }, (_, i) => Number(from) + i) : [numeric(part)];
  };
  return text.split(';').map((joint) => joint.split(/[\s,]+/).filter(Boolean).flatMap(range)).filter((joint) => joint.length);
}
