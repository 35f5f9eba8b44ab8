// Lab: what runs now, what came out lately, which robots there are.
import { explain, follow, getJson, send, summaryOf } from './api.js';
import { reached } from './criteria.js';
import { catalogue, forget, typeset } from './effect-catalogue.js';
import { fill, find, h, number, said, seconds, table, time, words } from './dom.js';
import { NAMES, page, state } from './job-words.js';
import { on } from './known-form.js';
import { invitation } from './tour.js';

const LIVE = ['queued', 'running'];
const RECENT = 12;
const followed = new Set();
function progress(job) {
  if (job.state === 'queued') return 'queued';
  if (job.step) return h('span', {}, `${job.step.what} `, h('progress', { value: job.step.done, max: job.step.of, 'aria-label': job.step.what }));
  const p = job.progress;
  if (!p) return 'starting';
  return `${reached(p)} after ${seconds(p.elapsed_s)}, ${p.starts_finished} starts`;
}

function running(job) {
  const cancel = h('button', { type: 'button', onclick: async () => {
    cancel.disabled = true;
    await send(`/jobs/${job.id}`, { method: 'DELETE' }).catch((e) => explain(find('#trouble'), e));
  } }, 'Cancel');
  return h('li', { class: 'row spread' }, h('span', {}, state(job), ' ', h('a', { href: page(job) }, NAMES[job.kind] ?? job.kind), job.robot ? ` for ${job.robot}` : null, ' ',
    h('span', { class: 'soft' }, progress(job))), cancel);
}

function showJobs(jobs) {
  const live = jobs.filter((j) => LIVE.includes(j.state)).reverse();
  fill(find('#now'), live.length ? h('ul', { class: 'list' }, live.map(running)) : h('p', { class: 'soft' }, 'No jobs running or queued.'));
  live.filter((j) => !followed.has(j.id)).forEach(keepUp);
  // As many as have a result read below; all others are among the runs.
  const ended = jobs.filter((j) => !LIVE.includes(j.state)).slice(0, RECENT);
  fill(find('#recent'), ended.length ? results(ended) : h('p', { class: 'soft' }, 'No results yet. A design takes half a minute.'));
}

function results(jobs) {
  return table([
    { head: 'Run', term: 'run', cell: (j) => h('a', { href: page(j) }, j.name ?? NAMES[j.kind] ?? j.kind), sort: (j) => j.kind },
    { head: 'Robot', cell: (j) => names.get(j.id) ?? j.robot ?? '–', sort: (j) => names.get(j.id) ?? '' },
    { head: 'Result', term: 'run_result', cell: (j) => outcome(j) },
    { head: 'State', term: 'run_state', cell: state, sort: (j) => j.state },
    { head: 'Ended', cell: (j) => time(j.finished_at ?? j.created_at), sort: (j) => j.finished_at ?? j.created_at },
  ], jobs, { caption: 'Newest first' });
}

/** Robot of a job, and what came out in a few words: from its result, which never changes, asked for once per browser. */
const KEPT = 'dynident.results';
const names = new Map();
const outcomes = new Map();
for (const [id, name, text] of JSON.parse(sessionStorage.getItem(KEPT) ?? '[]')) remember(id, name, text);

function remember(id, name, text) {
  names.set(id, name);
  if (text) outcomes.set(id, text);
}

function outcome(job) {
  if (job.error) return h('span', { class: 'soft' }, job.error.detail);
  const known = outcomes.get(job.id);
  return known ? said(known) : h('span', { class: 'soft' }, reached(job.progress) || '–');
}

/** Learns of results not seen yet, one after the other: some are megabytes. */
async function learn(jobs) {
  const unknown = jobs.filter((j) => ['finished', 'cancelled'].includes(j.state) && !names.has(j.id)).slice(0, RECENT);
  for (const job of unknown) {
    if (names.has(job.id)) continue;
    const result = await summaryOf(job).catch(() => null);
    remember(job.id, result?.robot ?? '–', outcomeOf(job, result));
    showJobs(jobs);
  }
  sessionStorage.setItem(KEPT, JSON.stringify([...names].slice(-200).map(([id, name]) => [id, name, outcomes.get(id)])));
}

const count = (n, what) => (n ? `${n} ${what}${n > 1 ? 's' : ''}` : 'nothing found');

function outcomeOf(job, result) {
  if (job.kind === 'excitation' && job.outcome === 'Infeasible') return 'no motion satisfies the limits';
  if (job.kind === 'excitation' && result?.rivals) return `${words(on(result.rivals.finding))} or ${on(result.rivals.rival)}: ${result.rivals.decides ? 'decides' : 'does not decide'}`;
  if (job.kind === 'excitation' && result?.condition_number) return `condition number ${number(result.condition_number)}`;
  if (job.kind === 'validation' && result?.logs) return `${result.logs.length} log${result.logs.length > 1 ? 's' : ''}${result.residual ? `, ${count(result.residual.findings.length, 'change')}` : ''}`;
  return result?.quality ? identified(result) : null;
}

function identified(result) {
  const findings = result.residual?.findings?.length;
  const quality = { good: 'good data', poor_excitation: 'poor excitation', unidentifiable: 'not identifiable' }[result.quality.verdict] ?? result.quality.verdict;
  return `${quality}${result.residual ? `, ${count(findings, 'finding')}` : ''}`;
}

async function keepUp(job) {
  followed.add(job.id);
  // A job reports many times a second, which is faster than anybody reads.
  let due = 0;
  await follow(job.id, () => {
    if (performance.now() < due) return;
    due = performance.now() + 500;
    refresh();
  }).catch(() => {});
  followed.delete(job.id);
  refresh();
}

async function refresh() {
  const { jobs } = await getJson('/jobs');
  showJobs(jobs);
  learn(jobs).catch((e) => explain(find('#trouble'), e));
  return jobs;
}

async function showRobots() {
  const { robots } = await getJson('/robots');
  fill(find('#robots'), table([
    { head: 'Name', cell: (r) => h('a', { href: `/robot?robot=${encodeURIComponent(r.id)}` }, r.name), sort: (r) => r.name },
    { head: 'ID', term: 'id', cell: (r) => h('span', { class: 'mono' }, r.id), sort: (r) => r.id },
    { head: 'Joints', number: true, cell: (r) => r.joints.length, sort: (r) => r.joints.length },
    { head: 'Remarks', hidden: true, cell: (r) => (r.shipped ? h('span', { class: 'tag' }, 'comes with dynident') : r.notes.length ? h('span', { class: 'tag warn', title: r.notes.join('\n') }, `${r.notes.length} notes`) : '') },
    { head: 'Design', hidden: true, cell: (r) => h('a', { href: `/design?robot=${encodeURIComponent(r.id)}` }, 'Design') },
    { head: 'Identify', hidden: true, cell: (r) => h('a', { href: `/identification?robot=${encodeURIComponent(r.id)}` }, 'Identify') },
  ], robots, { caption: 'All robots' }));
}

/** The catalogue, where it has something. */
async function showEffects() {
  const effects = await catalogue();
  find('#effects-part').hidden = !effects.length;
  fill(find('#effects'), table([
    { head: 'Name', cell: (e) => h('span', { class: 'mono' }, e.name), sort: (e) => e.name },
    { head: 'Torque', cell: (e) => typeset(e) },
    { head: 'Joint', cell: (e) => e.definition.joint ?? 'of the request', sort: (e) => e.definition.joint ?? '' },
    { head: 'Part of the model', term: 'own_effect', cell: (e) => (e.definition.declared ? 'declared' : 'tested like every effect') },
    { head: 'Delete', hidden: true, cell: (e) => h('button', { type: 'button', 'aria-label': `Delete ${e.name}`, onclick: () => remove(e.name) }, 'Delete') },
  ], effects, { caption: 'Catalogue of own effects' }));
}

async function remove(name) {
  if (!confirm(`Delete the effect ${name}? Runs that used it keep its formula.`)) return;
  await forget(name).then(showEffects).catch((e) => explain(find('#trouble'), e));
}

/** On an empty server first of all, later out of the way. */
function invite(jobs) {
  const place = find('#demo-place');
  if (!jobs.length) find('#trouble').after(place);
  invitation(place, !jobs.length);
}

Promise.all([refresh().then(invite), showRobots(), showEffects()]).catch((e) => explain(find('#trouble'), e));
setInterval(() => document.visibilityState === 'visible' && followed.size === 0 && refresh().catch(() => {}), 5000);
