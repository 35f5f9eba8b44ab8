// Holding an identified model against another log: what has changed since.
import { Refused, explain, getJson, send } from './api.js';
import { h, said, sentence } from './dom.js';
import { dataFault, findingParameters } from './finding.js';

export function checkModel(result) {
  if (!result.physical_parameters) return null;
  const file = h('input', { type: 'file', id: 'check-log', multiple: true });
  const trouble = h('div');
  const button = h('button', { type: 'submit' }, 'Check the model');
  const form = h('form', { novalidate: true, onsubmit: async (event) => {
    event.preventDefault();
    button.disabled = true;
    try {
      if (!file.files.length) throw new Refused({ detail: 'There is no log to check with.', hint: 'Choose one.' });
      const asked = result.provenance?.request ?? {};
      const model = await getJson(`/identify/${result.id}/model?format=json`);
      const body = new FormData();
      body.append('request', JSON.stringify({ model, columns: asked.columns, preprocess: asked.preprocess, prediction_points: 6000 }));
      [...file.files].forEach((f) => body.append('log', f, f.name));
      const job = await (await send('/validate', { method: 'POST', body })).json();
      sessionStorage.setItem(`dynident.checked.${job.id}`, result.id);
      location.href = `/identification?validation=${job.id}`;
    } catch (error) {
      explain(trouble, error);
    } finally {
      button.disabled = false;
    }
  } }, h('div', { class: 'row' }, h('label', { for: 'check-log', class: 'inline' }, 'Log'), h('span', { style: 'flex:1 1 15rem' }, file), button), trouble);
  return h('section', { class: 'card', id: 'check', 'aria-labelledby': 'check-title' }, h('h2', { id: 'check-title' }, 'Check the model on another log'),
    h('p', { class: 'soft' }, 'How well the model predicts another log, and what has changed since: a payload, a tilt after remounting, a drift of friction.'), form);
}

/** What has changed since the model was made, in the words of the interface. */
export function changes(residual) {
  if (!residual) return null;
  const faults = residual.data_faults.map(dataFault);
  const found = residual.findings.map((f) => h('div', { class: 'finding', 'data-effect': f.effect }, h('p', { class: 'sentence' }, said(f.sentence)), findingParameters(f)));
  const all = residual.findings.length || residual.remainder;
  return h('section', { class: 'card', id: 'changes', 'aria-labelledby': 'changes-title' }, h('h2', { id: 'changes-title' }, 'Changes since the model was identified'),
    h('p', {}, h('span', { class: `tag ${all ? 'warn' : 'good'}` }, all ? 'Changed' : 'Still holds'), ' ', h('strong', {}, said(all ? sentence(residual.summary) : 'No change found: the residual is noise.'))), faults, found, residual.remainder ? h('p', {}, said(residual.remainder.sentence)) : null);
}
