// Formulas as MathML, which browsers set by themselves.
const NAMESPACE = 'http://www.w3.org/1998/Math/MathML';

/** An element of MathML; text becomes its content. */
export function m(tag, ...children) {
  const element = document.createElementNS(NAMESPACE, tag);
  element.append(...children.flat(Infinity));
  return element;
}

/** Attributes of MathML that say how it looks. */
const LOOKS = ['mathvariant', 'stretchy', 'display', 'accent'];

/** Elements of a formula that came as MathML: what is no MathML is left out. */
export function formula(text) {
  const copy = (from) => {
    const element = m(from.localName);
    for (const name of LOOKS) if (from.hasAttribute(name)) element.setAttribute(name, from.getAttribute(name));
    for (const child of from.childNodes) {
      if (child.nodeType === Node.TEXT_NODE) element.append(child.data);
      else if (child.nodeType === Node.ELEMENT_NODE && /^m[a-z]+$/.test(child.localName)) element.append(copy(child));
    }
    return element;
  };
  const { documentElement } = new DOMParser().parseFromString(text, 'application/xml');
  return documentElement.localName === 'math' ? copy(documentElement) : null;
}

const operator = (sign, ...attributes) => {
  const mo = m('mo', sign);
  attributes.forEach(([name, value]) => mo.setAttribute(name, value));
  return mo;
};
const upright = ['stretchy', 'false'];

/** `MY`, `2` → MY with the link below, as in the literature. */
export const symbol = (name, index) => {
  const letters = m('mi', name);
  // Single letters would be slanted twice, by MathML and by the style sheet, which slants names of several letters.
  letters.setAttribute('mathvariant', 'normal');
  return m('msub', letters, m('mn', index));
};

const named = (text) => {
  const [, name, index] = /^([A-Z]+)(\d+)$/.exec(text) ?? [];
  return name ? symbol(name, index) : m('mtext', text);
};

/** The name of a base parameter. */
export const nameOf = (text) => m('math', named(text));

/**
 * An expression in standard parameters, `MY2 + 0.42 (M3 + M4)`; with `name` as the equation that defines it. One formula per term: lines
 * break between formulas and never within.
 */
export function typeset(text, name) {
  const place = document.createElement('span');
  place.className = 'expression';
  const equation = name && name !== text;
  if (equation) place.append(m('math', named(name), operator('=')), ' ');
  if (!/^[-A-Z\d.() +e*^]+$/.test(text)) {
    place.append(text);
    return place;
  }
  let term = [];
  const flush = () => {
    if (term.length) place.append(m('math', term), ' ');
    term = [];
  };
  for (const token of text.match(/[A-Z]+\d+|\d+(?:\.\d+)?(?:e[-+]?\d+)?|[-+()*^]/g) ?? []) {
    if ('+-'.includes(token)) {
      flush();
      term.push(operator(token === '-' ? '−' : '+', ['form', place.childNodes.length > (equation ? 2 : 0) ? 'infix' : 'prefix']));
    } else if ('()'.includes(token)) term.push(operator(token, upright));
    else if (token === '*') term.push(operator('·'));
    else if (/^\d/.test(token)) term.push(m('mn', token), operator('\u2062'));
    else term.push(named(token));
  }
  flush();
  return place;
}

/** `q_j(t) = q_j0 + Σ a/(ωl) sin(ωlt) − b/(ωl) cos(ωlt)`, the form of every designed motion. */
export function fourierSeries(fundamentalHz) {
  const [mi, mo, mn] = ['mi', 'mo', 'mn'].map((tag) => (text) => m(tag, text));
  const row = (...parts) => m('mrow', parts);
  const omega = () => mi('ω');
  const angle = () => row(operator('(', upright), omega(), mi('l'), mi('t'), operator(')', upright));
  const part = (letter, wave) => row(m('mfrac', m('msub', mi(letter), mi('l')), row(omega(), mi('l'))), mi(wave), angle());
  const math = m('math', mi('q'), operator('(', upright), mi('t'), operator(')', upright), mo('='), m('msub', mi('q'), mn('0')), mo('+'),
    m('munderover', mo('∑'), row(mi('l'), mo('='), mn('1')), mi('L')), operator('(', upright), part('a', 'sin'), mo('−'), part('b', 'cos'), operator(')', upright), mo(','),
    m('mspace'), omega(), mo('='), mn('2'), mi('π'), mo('·'), mn(fundamentalHz), m('mtext', '\u00a0Hz'));
  math.setAttribute('displaystyle', 'true');
  return math;
}
