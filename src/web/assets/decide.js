// What to record next: the trajectory that separates a finding from its rival, or one that adds most to what is known.
import { explain, getJson, postJson } from './api.js';
import { h } from './dom.js';

/** Periods to record: their repetition measures the noise, and five of them do that well. */
const PERIODS = 5;

/** The design that was executed, where the request of the identification names one: its limits and its period hold for the next one, too. */
async function executed(result) {
  const id = result.provenance?.request?.excitation;
  return typeof id === 'string' ? getJson(`/excitation/${id}`).catch(() => null) : null;
}

function periodOf(result) {
  const said = result.log_report.map((l) => l.choices.find((c) => c.what === 'period')?.value);
  return said.map(Number.parseFloat).find((v) => v > 0) ?? 10;
}

/** The request for the next trajectory; `pair` = {finding, rival} is what it shall tell apart. */
export async function nextRequest({ result }, pair) {
  const design = await executed(result);
  const before = design?.request;
  const asked = result.provenance?.request ?? {};
  return {
    robot: typeof asked.robot === 'string' ? asked.robot : result.provenance.robot,
    fourier: { order: before?.fourier?.order ?? 5, fundamental_hz: design?.fundamental_hz ?? 1 / periodOf(result) }, sample_rate_hz: before?.sample_rate_hz ?? 100,
    model: { identification: result.id }, given: [{ identification: result.id }], periods: PERIODS,
    ...(pair ? { criterion: 'rival_evidence', rivals: pair } : { criterion: 'i_optimality' }),
    constraints: before?.constraints ?? { form: 'exact', start: 'free' }, search: { seed: 1, time_limit_s: 20 },
  };
}

/** What was asked for, until the answer says it: the page of a search shows it beside the search. */
const key = (id) => `dynident.asked.${id}`;
const keepAsked = (id, request) => sessionStorage.setItem(key(id), JSON.stringify(request));
export const askedFor = (id) => JSON.parse(sessionStorage.getItem(key(id)) ?? 'null');

/** A button that designs it and goes to the page where the search is seen. */
export function designButton(context, label, pair, id) {
  const trouble = h('div');
  const button = h('button', { type: 'button', class: 'primary', id }, label);
  button.addEventListener('click', async () => {
    button.disabled = true;
    try {
      const request = await nextRequest(context, pair);
      const job = await postJson('/excitation', request);
      keepAsked(job.id, request);
      location.href = `/design?id=${job.id}`;
    } catch (error) {
      button.disabled = false;
      explain(trouble, error);
    }
  });
  return h('div', {}, h('div', { class: 'actions' }, button), trouble);
}
