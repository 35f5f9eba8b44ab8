// Runs: all jobs with their names and notes, filtered, compared and deleted.
import { explain, getJson, send } from './api.js';
import { compareRuns } from './runs-compare.js';
import { NAMES, page, state } from './job-words.js';
import { fill, find, h, seconds, table, time } from './dom.js';
import { unmark } from './field-errors.js';

const FILTERS = ['search', 'robot', 'kind', 'state'];
const chosen = new Set();
/** Ids of the robots that are kept: a run may be of one that came in its request, or was deleted. */
let robots = new Set();
let jobs = [];
let next = null;

const query = () => new URLSearchParams(FILTERS.map((f) => [f, find(`#${f}`).value.trim()]).filter(([, v]) => v));

/** The list as the filters say; the address says so as well, to be shared and kept. */
async function load() {
  const filters = query();
  const address = new URLSearchParams(filters);
  const compared = new URLSearchParams(location.search).get('compare');
  if (compared) address.set('compare', compared);
  history.replaceState(null, '', `/runs${[...address].length ? `?${address}` : ''}`);
  const list = await getJson(`/jobs?limit=100${[...filters].length ? `&${filters}` : ''}`);
  [jobs, next] = [list.jobs, list.next];
  show();
}

async function older() {
  const list = await getJson(next);
  jobs.push(...list.jobs);
  next = list.next;
  show();
}

const lasted = (job) => (job.started_at && job.finished_at ? (new Date(job.finished_at) - new Date(job.started_at)) / 1000 : null);

function show() {
  find('#more').hidden = !next;
  find('#compare').disabled = chosen.size < 2;
  if (!jobs.length) {
    fill(find('#list'), h('p', { class: 'soft' }, [...query()].length ? 'No run matches.' : 'No runs yet.'));
    return;
  }
  // A server without tokens knows no owners.
  fill(find('#list'), table([
    { head: 'Select', hidden: true, cell: select }, { head: 'Name', term: 'run', cell: named, sort: (j) => j.name ?? '' }, { head: 'Kind', term: 'run_kind', cell: (j) => NAMES[j.kind] ?? j.kind, sort: (j) => j.kind }, { head: 'Robot', cell: (j) => (robots.has(j.robot) ? h('a', { href: `/robot?robot=${encodeURIComponent(j.robot)}` }, j.robot) : j.robot ?? '–'), sort: (j) => j.robot ?? '' },
    { head: 'Logs', cell: (j) => h('div', { class: 'logs' }, j.logs?.length ? j.logs.join(', ') : '–'), sort: (j) => j.logs?.[0] ?? '' },
    { head: 'State', term: 'run_state', cell: state, sort: (j) => j.state }, { head: 'Started', cell: (j) => h('span', { class: 'nowrap' }, time(j.started_at ?? j.created_at)), sort: (j) => j.started_at ?? j.created_at }, { head: 'Duration', term: 'run_duration', number: true, cell: (j) => (lasted(j) === null ? '–' : seconds(lasted(j))), sort: lasted },
    ...(jobs.some((j) => j.owner) ? [{ head: 'Owner', term: 'run_owner', cell: (j) => j.owner ?? '–', sort: (j) => j.owner ?? '' }] : []), { head: 'Actions', hidden: true, cell: actions },
  ], jobs, { caption: `${jobs.length} run${jobs.length > 1 ? 's' : ''}${next ? ', and older ones' : ''}` }));
}

function select(job) {
  const can = job.kind !== 'validation' && ['finished', 'cancelled'].includes(job.state);
  return h('input', { type: 'checkbox', checked: chosen.has(job.id), disabled: !can, 'aria-label': `Select ${job.name ?? job.id}`, onchange: (e) => { if (e.target.checked) chosen.add(job.id); else chosen.delete(job.id); find('#compare').disabled = chosen.size < 2; } });
}

const named = (job) => h('div', { class: 'meaning' }, h('a', { href: page(job) }, job.name ?? h('span', { class: 'mono' }, job.id.slice(0, 8))), job.note ? h('div', { class: 'help note' }, job.note) : null, job.error ? h('div', { class: 'help' }, job.error.detail) : null);

function actions(job) {
  const ended = !['queued', 'running'].includes(job.state);
  const name = job.name ?? job.id.slice(0, 8);
  return h('div', { class: 'row', style: 'flex-wrap:nowrap' }, h('button', { type: 'button', 'aria-label': `Edit name and note of ${name}`, onclick: () => edit(job) }, 'Edit'),
    h('button', { type: 'button', 'aria-label': `${ended ? 'Delete' : 'Cancel'} ${name}`, onclick: () => end(job, ended).catch((e) => explain(find('#trouble'), e)) }, ended ? 'Delete' : 'Cancel'));
}

async function end(job, ended) {
  if (ended && !confirm(`Delete the ${(NAMES[job.kind] ?? job.kind).toLowerCase()} ${job.name ?? job.id.slice(0, 8)} with its result? This cannot be undone.`)) return;
  await send(`/jobs/${job.id}${ended ? '?forget=true' : ''}`, { method: 'DELETE' });
  chosen.delete(job.id);
  await load();
}

function edit(job) {
  const dialog = find('#edit');
  find('#edit-name').value = job.name ?? '';
  find('#edit-note').value = job.note ?? '';
  unmark(find('#edit-form'));
  fill(find('#edit-trouble'));
  dialog.returnValue = 'cancel';
  find('#edit-form').onsubmit = async (event) => {
    if (event.submitter?.value !== 'save') return;
    event.preventDefault();
    try {
      await send(`/jobs/${job.id}`, { method: 'PATCH', headers: { 'content-type': 'application/json' }, body: JSON.stringify({ name: find('#edit-name').value, note: find('#edit-note').value }) });
      dialog.close();
      await load();
    } catch (error) {
      explain(find('#edit-trouble'), error, find('#edit-form'));
    }
  };
  dialog.showModal();
}

async function compare(ids) {
  const address = new URLSearchParams(location.search);
  address.set('compare', ids.join(','));
  history.replaceState(null, '', `/runs?${address}`);
  await compareRuns(find('#comparison'), ids);
}

let waiting = null;
find('#filters').addEventListener('input', () => { clearTimeout(waiting); waiting = setTimeout(() => load().catch((e) => explain(find('#trouble'), e)), 300); });
find('#filters').addEventListener('submit', (e) => e.preventDefault());
find('#more').addEventListener('click', () => older().catch((e) => explain(find('#trouble'), e)));
find('#compare').addEventListener('click', () => compare([...chosen]).then(() => find('#comparison').scrollIntoView({ block: 'start' }), (e) => explain(find('#trouble'), e)));

async function begin() {
  const given = new URLSearchParams(location.search);
  const known = (await getJson('/robots')).robots;
  robots = new Set(known.map((r) => r.id));
  find('#robot').append(...known.map((r) => h('option', { value: r.id }, r.name)));
  FILTERS.forEach((f) => { find(`#${f}`).value = given.get(f) ?? ''; });
  const compared = given.get('compare')?.split(',').filter(Boolean) ?? [];
  compared.forEach((id) => chosen.add(id));
  await load();
  if (compared.length > 1) await compare(compared);
}

begin().catch((e) => explain(find('#trouble'), e));
