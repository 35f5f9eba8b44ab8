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
  if (job.state === 'finished' && job.outcome === 'Infeasible') return h('span', { class: 'tag bad' }, 'infeasible');
  // Whoever stops a search keeps its best motion, which is a result like any other.
  if (job.state === 'cancelled' && job.outcome) return h('span', { class: 'tag good' }, 'stopped early');
  return h('span', { class: `tag ${kinds[job.state] ?? ''}` }, job.state);
}

/** How a search ended. */
export const searchEnd = (status) => (status === 'BudgetExhausted' ? 'Time limit reached' : words(status));
