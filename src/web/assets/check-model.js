// Holding an identified model against another log: what has changed since.
import { Refused, explain, getJson, send } from './api.js';
import { fill, h, mark, said, sentence } from './dom.js';
import { unmark } from './field-errors.js';
import { dataFault, findingParameters } from './finding.js';
import { LogColumns } from './log-columns.js';
import { readHead } from './log-file.js';

/** Points of every plotted series, as of an identification. */
const POINTS = 6000;

export function checkModel(result) {
  if (!result.physical_parameters) return null;
  const asked = result.provenance?.request ?? {};
  const file = h('input', { type: 'file', id: 'check-log', multiple: true });
  const [trouble, place] = [h('div'), h('div')];
  const period = h('input', { id: 'check-period', class: 'cell-name', inputmode: 'decimal', placeholder: 'found in the data', 'data-pointer': '/period_s', 'data-label': 'Period' });
  const trace = h('input', { id: 'check-trace', type: 'checkbox', checked: true });
  const columns = new LogColumns(place, () => {});
  const button = h('button', { type: 'submit' }, 'Check the model');
  const form = h('form', { novalidate: true, onsubmit: async (event) => {
    event.preventDefault();
    button.disabled = true;
    unmark(form);
    fill(trouble);
    try {
      if (!file.files.length) throw new Refused({ detail: 'There is no log to check with.', hint: 'Choose one.' });
      if (columns.head && columns.missing().length) throw new Refused({ detail: `The columns are not complete: ${columns.missing().join('; ')}.`, hint: 'Choose them in the table of columns.' });
      const model = await getJson(`/identify/${result.id}/model?format=json`);
      const body = new FormData();
      const stated = period.value.trim().replace(',', '.');
      body.append('request', JSON.stringify({ model, columns: columns.head ? columns.value() : asked.columns, preprocess: asked.preprocess, period_s: stated ? Number(stated) || stated : undefined, trace: trace.checked, prediction_points: POINTS }));
      [...file.files].forEach((f) => body.append('log', f, f.name));
      const job = await (await send('/validate', { method: 'POST', body })).json();
      sessionStorage.setItem(`dynident.checked.${job.id}`, result.id);
      location.href = `/identification?validation=${job.id}`;
    } catch (error) {
      explain(trouble, error, form);
    } finally {
      button.disabled = false;
    }
  } }, h('div', { class: 'row' }, h('label', { for: 'check-log', class: 'inline' }, 'Log'), h('span', { style: 'flex:1 1 15rem' }, file), button),
  h('details', {}, h('summary', {}, 'Period, diagnosis'), h('div', { class: 'row' }, h('span', { class: 'labelled' }, h('label', { for: 'check-period', class: 'inline' }, 'Period (s)'), mark('period', 'Period')), h('div', { class: 'field', style: 'margin:0' }, period), h('label', { class: 'inline' }, trace, 'Look for what has changed'))), trouble, place);
  file.addEventListener('change', () => showColumns(result, asked, file.files, columns).catch((e) => { columns.clear(); explain(trouble, e); }));
  return h('section', { class: 'card', id: 'check', 'aria-labelledby': 'check-title' }, h('h2', { id: 'check-title' }, 'Check the model on another log'),
    h('p', { class: 'soft' }, 'How well the model predicts another log, and what has changed since: a payload, a tilt after remounting, a drift of friction.'), form);
}

/** A log with the columns of the identification is read as that was; of any other the columns are assigned. */
async function showColumns(result, asked, files, columns) {
  columns.clear();
  if (!files.length) return;
  const head = await readHead(files[0]);
  const there = (name) => !name || head.columns.some((c) => c.name === name);
  const { time, position, velocity, torque } = asked.columns ?? {};
  if (asked.columns && [time, ...[position, velocity, torque].flatMap((q) => q?.headers ?? [])].every(there)) return;
  columns.show(head, { id: asked.robot ?? result.robot, joints: result.joints }, { files: [...files].slice(1).map((f) => f.name) });
  // What the usual names say needs no table.
  if (!columns.value() && !columns.missing().length) columns.clear();
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
