// What an identification is doing, and what it needs beside the new log.
import { explain, getJson, send } from './api.js';
import { fill, find, h } from './dom.js';

/** A design that was made after an identification adds to its data: says which log is needed again. */
export async function sayWhatJoins(id) {
  const { provenance } = await getJson(`/identify/${id}?predictions=false`);
  const again = (provenance?.logs ?? []).filter((l) => l.role === 'identification').map((l) => l.file);
  if (!again.length) return;
  const place = find('#joins');
  place.hidden = false;
  fill(place, h('p', {}, h('strong', {}, 'Two logs together.'), ' This motion was designed for what ', again.length > 1 ? 'earlier logs leave' : 'an earlier log leaves', ' open. Give the new log and ',
    again.map((name, i) => [i ? ', ' : null, h('span', { class: 'mono' }, name)]), ` once more (of the `, h('a', { href: `/identification?id=${id}` }, 'earlier identification'), ').'));
}

/** The step of a job that runs, with a button that ends it. */
export function showStep(live, job) {
  live.hidden = false;
  const step = job.step;
  const text = job.state === 'queued' ? 'Waiting for its turn' : step ? step.what : 'Beginning';
  const cancel = h('button', { type: 'button', onclick: () => send(`/jobs/${job.id}`, { method: 'DELETE' }).catch((e) => explain(find('#trouble'), e)) }, 'Cancel');
  fill(live, h('div', { class: 'row spread' }, h('h2', {}, text.charAt(0).toUpperCase() + text.slice(1)), cancel), h('progress', { value: step?.done ?? 0, max: step?.of ?? 1, 'aria-label': text }));
}
