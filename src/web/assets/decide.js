// What would decide between a finding and its rivals, and the button that designs it.
import { explain, postJson } from './api.js';
import { h } from './dom.js';

/**
 * The request for a trajectory that tells more than the one that was run. Effects look alike when they moved the torque alike along one
 * path. Seven harmonics from anywhere, chosen for what they say about torques all over the workspace, pass through other combinations of
 * position, speed and load; the interface has no criterion yet that weighs two effects against each other.
 */
export function decidingRequest({ result }) {
  const noise = result.residual.noise_floor;
  const asked = result.provenance?.request ?? {};
  const period = result.log_report.map((l) => l.choices.find((c) => c.what === 'period')).map((c) => Number.parseFloat(c?.value)).find((v) => v > 0) ?? 10;
  return {
    robot: typeof asked.robot === 'string' ? asked.robot : result.provenance.robot, fourier: { order: 7, fundamental_hz: 1 / period }, sample_rate_hz: 100,
    criterion: 'i_optimality', constraints: { form: 'exact', start: 'free' }, torque_noise: noise.every((n) => n > 0) ? noise : undefined, search: { seed: 1, time_limit_s: 30 },
  };
}

export function decision(context) {
  if (!context.result.provenance) return null;
  const trouble = h('div');
  const button = h('button', { type: 'button', class: 'primary', id: 'decide' }, 'Design the deciding trajectory');
  button.addEventListener('click', async () => {
    button.disabled = true;
    try {
      const job = await postJson('/excitation', decidingRequest(context));
      location.href = `/design?id=${job.id}`;
    } catch (error) {
      button.disabled = false;
      explain(trouble, error);
    }
  });
  return h('div', {}, h('div', { class: 'actions' }, button), trouble);
}
