// How jobs are called, where they are shown, and how they stand.
import { h, words } from './dom.js';

export const NAMES = { excitation: 'Design', identification: 'Identification', validation: 'Validation' };

/** The page that shows a job. */
export function page(job) {
  if (job.kind === 'excitation') return `/design?id=${job.id}`;
  if (job.kind === 'identification') return `/identification?id=${job.id}`;
  return `/identification?validation=${job.id}`;
}

export function state(job) {
  const kinds = { queued: '', running: 'live', finished: 'good', cancelled: 'warn', failed: 'bad' };
  const text = job.state === 'finished' && job.outcome === 'Infeasible' ? 'infeasible' : job.state;
  return h('span', { class: `tag ${text === 'infeasible' ? 'bad' : kinds[job.state] ?? ''}` }, text);
}

/** How a search ended. */
export const searchEnd = (status) => (status === 'BudgetExhausted' ? 'Time limit reached' : words(status));
