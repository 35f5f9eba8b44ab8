// Why there is no motion, at the form.
import { explain } from './api.js';
import { reasonOf } from './design-result.js';
import { find } from './dom.js';

/** No motion: said at the field that stands in its way, and at the button, beside the result. */
export function sayWhatIsInTheWay(result) {
  const { space, torque } = result.request.constraints ?? {};
  const [, from] = /from `([^`]+)`/.exec(result.reason) ?? [];
  const obstacle = ['half_spaces', 'boxes'].flatMap((kind) => (space?.[kind] ?? []).map((o, i) => [o.name, `/constraints/space/${kind}/${i}`])).find(([name]) => name === from);
  const field = obstacle?.[1] ?? (result.joints.includes(from) ? '/constraints/space/self_collision/ignore' : torque && result.reason.includes('constraints.torque') ? '/constraints/torque/limits' : '/constraints/start_position');
  explain(find('#form-trouble'), { problem: { detail: 'no motion satisfies the request', errors: [{ pointer: field, detail: reasonOf(result).replace(/^W/, 'w') }] } }, find('#form'), { quiet: true });
}
