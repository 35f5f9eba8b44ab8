// The HTTP interface, as any client would use it.
import { fill, h, sentence } from './dom.js';
import { errorLine, markError } from './field-errors.js';

const TOKEN = 'dynident.token';
export const token = () => localStorage.getItem(TOKEN);
export const keepToken = (value) => (value ? localStorage.setItem(TOKEN, value) : localStorage.removeItem(TOKEN));

/** What the interface says of a request that it refuses: `problem` is its document (RFC 9457). */
export class Refused extends Error {
  constructor(problem) {
    super(problem.detail ?? problem.title);
    this.problem = problem;
  }
}

/** fetch with the token; throws `Refused` with the problem document of any answer that is none. */
export async function send(path, options = {}) {
  const headers = new Headers(options.headers);
  if (token()) headers.set('authorization', `Bearer ${token()}`);
  let answer;
  try {
    answer = await fetch(path, { ...options, headers });
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new Refused({ code: 'unreachable', detail: 'The server does not answer.', hint: 'Is it still running? The page works again as soon as it is.' });
  }
  if (answer.ok) return answer;
  const problem = await answer.json().catch(() => ({ code: `http_${answer.status}`, detail: `The server answered ${answer.status}.` }));
  if (answer.status === 401) document.dispatchEvent(new CustomEvent('token-wanted'));
  throw new Refused(problem);
}

export const getJson = async (path, options) => (await send(path, options)).json();

/** The result of a job without the series to draw, which are most of it. */
export const summaryOf = (job) => getJson(`${job.links.result}${job.kind === 'identification' ? '?predictions=false' : ''}`);

export const postJson = async (path, document) =>
  (await send(path, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(document) })).json();

/** Follows a job: calls `tell(job)` at every change, resolves with the job when it has ended. Goes on after a broken line. */
export async function follow(id, tell, signal) {
  let last = '0';
  for (let failures = 0; ; ) {
    try {
      const answer = await send(`/jobs/${id}/events`, { headers: { 'last-event-id': last, accept: 'text/event-stream' }, signal });
      if (answer.status === 204) return await getJson(`/jobs/${id}`);
      for await (const event of events(answer.body)) {
        last = event.id ?? last;
        failures = 0;
        const job = JSON.parse(event.data);
        tell(job);
        if (event.event === 'end') return job;
      }
    } catch (error) {
      if (signal?.aborted || (error instanceof Refused && error.problem.status)) throw error;
    }
    failures += 1;
    await new Promise((done) => setTimeout(done, Math.min(5000, 300 * 2 ** failures)));
  }
}

async function* events(body) {
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  let text = '';
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    text += value;
    const blocks = text.split('\n\n');
    text = blocks.pop();
    for (const block of blocks) {
      const event = {};
      for (const line of block.split('\n')) {
        const at = line.indexOf(':');
        if (at > 0) event[line.slice(0, at)] = line.slice(at + 1).trimStart();
      }
      if (event.data) yield event;
    }
  }
}

/** A link that downloads; with a token the file is fetched with it. */
export function download(label, path, name) {
  const link = h('a', { class: 'button', href: path, download: name }, label);
  link.addEventListener('click', async (event) => {
    if (!token()) return;
    event.preventDefault();
    save(await (await send(path)).blob(), name);
  });
  return link;
}

export function save(blob, name) {
  const address = URL.createObjectURL(blob);
  h('a', { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** Where the pages list what a route lists. */
const LISTS = { 'GET /jobs lists them': ['/runs', 'All runs'], 'GET /robots lists them': ['/robot', 'All robots'], 'GET /effects lists them': ['/#effects-part', 'The effects of the lab'] };
const remedy = ({ hint, status }) => (status === 401 ? 'Enter a token under “Access”; whoever runs this server makes one with dynident token create.' : LISTS[hint] ? h('a', { href: LISTS[hint][0] }, LISTS[hint][1]) : sentence(hint));
/** Titles of the interface in the words of the pages; names in it stand between quotation marks. */
const headline = (problem) => sentence(problem.status === 401 && !token() ? 'this server asks for a token' : problem.detail ?? problem.title).replace(/^The (excitation|identification|validation|motion) request has/, 'The request has').replace(/`([^`]*)`/g, '“$1”');

/**
 * Shows what went wrong at `place`, in the words of the interface; `form` gets the fields marked that it names. `quiet`: where somebody is typing, nothing
 * moves.
 */
export function explain(place, error, form, { quiet = false } = {}) {
  if (error.name === 'AbortError') return;
  const problem = error.problem ?? { detail: `The page failed: ${error.message}` };
  const all = (problem.errors ?? []).map((e) => markError(form, e));
  // At the button as well as at the field: what is wrong may be out of sight, or in a part that is folded.
  fill(place, h('div', { class: 'problem', role: 'alert' }, h('strong', {}, headline(problem)), problem.hint ? h('p', {}, remedy(problem)) : null,
    all.length ? h('ul', {}, all.map(errorLine)) : null));
  if (!error.problem) console.error(error);
  if (quiet) return;
  const bad = all.find((e) => e.field)?.field;
  (bad ?? place).scrollIntoView({ block: 'center', inline: 'center' });
  bad?.focus();
}
