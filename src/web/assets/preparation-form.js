// How logs are prepared and how physical parameters are found, as the form of an identification has it; what is left empty the program chooses.
import { find } from './dom.js';
import { numeric, some, value } from './form-values.js';

const numbers = (of) => Object.fromEntries(Object.entries(of).map(([key, id]) => [key, numeric(value(id))]));
const chosen = (id) => (value(id) === '' ? undefined : value(id) === 'yes');

/** `preprocess` of a request. */
export function preprocess() {
  const filter = (name) => some(numbers({ order: `${name}-order`, cutoff_hz: `${name}-cutoff` }));
  return some({ method: value('method') || undefined, average: chosen('average'), position_filter: filter('position-filter'), torque_filter: filter('torque-filter'),
    ...numbers({ discard_edges_s: 'discard-edges', decimation: 'keep-every', dead_zone: 'dead-zone' }) });
}

/** `feasible` of a request. */
export function feasible() {
  if (!find('#feasible').checked) return { method: 'none' };
  return { method: value('feasible-method'), ...numbers({ prior_weight: 'prior-weight', least_eigenvalue: 'least-eigenvalue', least_viscous: 'least-viscous', starts: 'paper-starts', seed: 'paper-seed' }),
    gazebo: chosen('gazebo'), triangle: value('triangle') || undefined, slender_axes: axes(value('slender-axes')), bounds: bounds(value('link-bounds')) };
}

/** `z, none, x` → one per link. */
function axes(text) {
  return text ? text.split(/[\s,;]+/).filter(Boolean).map((axis) => (axis === 'none' ? null : axis)) : undefined;
}

/** A text that is no JSON goes to the server, which says so at the field. */
function bounds(text) {
  try {
    return text ? JSON.parse(text) : undefined;
  } catch {
    return text;
  }
}

/** What only the nonlinear problem has is asked for where it is chosen. */
export function showMethod() {
  find('#physical-part').hidden = !find('#feasible').checked;
  find('#paper-only').hidden = value('feasible-method') === 'consistent';
}
