// The result of an identification.
import { changes, checkModel } from './check-model.js';
import { download, postJson, save, send, token } from './api.js';
import { fill, figure, h, measured, number, said, sentence, shortNames, table, term, unit, words } from './dom.js';
import { byGain, effectName, faultName, gain, parameterName } from './finding.js';
import { step } from './log-preview.js';
import { parameters } from './parameters.js';
import { physical } from './physical.js';
import { MODELS, torquePlots } from './torque-plots.js';

export const VERDICTS = {
  good: ['good', 'Good data'], poor_excitation: ['warn', 'Poor excitation'], unidentifiable: ['bad', 'Not identifiable'],
  explains_nothing: ['bad', 'The model explains nothing'], data_fault: ['bad', 'Fault of the data'],
};
export const RESIDUAL = {
  nothing_missing: ['good', 'Nothing is missing: the residual is noise.'], explained: ['good', 'The residual is explained.'],
  partly_explained: ['warn', 'A part of the residual is explained.'], unexplained: ['bad', 'A part of the residual has no explanation.'],
};
const section = (id, title, ...parts) => h('section', { class: 'card', id, 'aria-labelledby': `${id}-title` }, h('h2', { id: `${id}-title` }, title), parts);

/** Units of torque per joint, from the robot that stands in the result. */
async function drawnRobot(result) {
  return result.provenance ? postJson('/motion', { robot: result.provenance.robot }) : null;
}

export async function showIdentification(target, result) {
  const drawn = await drawnRobot(result);
  const effort = result.joints.map((_, j) => unit(drawn?.joints[j].effort_unit ?? 'N m'));
  const parts = [['summary', 'Summary'], ['torques', 'Torques'], ['parameters', 'Parameters'], ['physical', 'Physical'], ['errors', 'Errors'], ['logs', 'Logs'], ...(result.physical_parameters ? [['check', 'Check']] : [])];
  fill(target, h('nav', { class: 'toc', 'aria-label': 'Parts of the result' }, parts.map(([id, name]) => h('a', { href: `#${id}` }, name))),
    summary(result, effort), notes(result), torquePlots(result, effort), parameters(result), effectsFound(result), physical(result, drawn), errors(result, effort), logs(result), checkModel(result));
}

/** The result of a validation: a model held against logs; `made` is the identification that made the model, if it is known. */
export function showValidation(target, result, made) {
  const effort = result.joints.map((_, j) => (made?.provenance ? { prismatic: 'N' }[made.provenance.robot.joints[j].kind] ?? 'N·m' : 'N·m or N'));
  const rows = result.logs.map((log) => ({ log: log.name, ...log }));
  const joint = (name, j) => ({ head: name, own: true, number: true, cell: (r) => h('span', {}, number(r.rms[j], 3), h('br'), h('small', { class: 'soft' }, `${number(r.percent[j], 2)} %`)), sort: (r) => r.rms[j] });
  const worst = result.logs[0]?.percent ?? [];
  const origin = made ? h('p', {}, 'The model is that of ', h('a', { href: `/identification?id=${made.id}` }, `an identification from ${made.provenance.logs.filter((l) => l.role === 'identification').map((l) => l.file).join(', ')}`), '.') : null;
  fill(target, changes(result.residual), section('errors', `${result.robot}: the model against ${result.logs.map((l) => l.name).join(', ')}`, origin, h('p', { class: 'soft' }, 'Root mean square of measured less predicted torque (N·m, or N for prismatic joints), of the model as it is, with its effects; below it the share of the torque’s own. Changes are searched for with the model’s parameters free within their standard deviations, and reported in errors of single measurements.'),
    table([{ head: 'Log', cell: (r) => r.log, sort: (r) => r.log }, ...result.joints.map(joint), { head: 'Sum', number: true, cell: (r) => number(r.sum, 3), sort: (r) => r.sum }], rows, { caption: 'RMS errors' })),
  torquePlots(result, effort, { models: { ...MODELS, base: 'the model' }, first: worst.indexOf(Math.max(...worst)) }), logs(result));
}

function notes(result) {
  return result.notes.length ? h('div', { class: 'notice' }, result.notes.map((n) => h('p', {}, said(sentence(n))))) : null;
}

function summary(result, effort) {
  const q = result.quality;
  const [kind, name] = VERDICTS[q.verdict] ?? ['', words(q.verdict)];
  const residual = result.residual;
  const all = result.base_parameters.length;
  const known = result.base_parameters.filter((p) => p.value !== null).length;
  const extra = q.columns - all;
  return section('summary', result.robot, residual ? foundIn(result, effort) : null, h('p', {}, h('span', { class: `tag ${kind}` }, term('quality', name)), ' ', said(sentence(q.reason)), richer(result)),
    h('dl', { class: 'figures' }, figure([term('base_parameters', 'Base parameters'), ' ', term('rank', 'determined')], `${known} of ${all}`), extra > 0 ? figure('Parameters of effects and offsets', `${Math.max(q.rank - known, 0)} of ${extra}`) : null, figure(term('scaled_condition_number', 'Condition number, columns scaled'), number(q.condition_number, 3)),
      result.feasibility ? figure(term('physical_fit', 'Physical fit'), number(result.feasibility.rms_ratio, 4), '× that of the base parameters') : null),
    files(result));
}

/** Where a log says too little: the way to one that says more. */
function richer(result) {
  const robot = result.provenance?.request?.robot;
  if (!['poor_excitation', 'unidentifiable'].includes(result.quality.verdict)) return null;
  return [' ', h('a', { href: `/design${typeof robot === 'string' ? `?robot=${encodeURIComponent(robot)}` : ''}` }, 'Design a motion that excites all parameters'), '.'];
}

/** What the verdict was judged by. */
function scope({ held_out: held }) {
  if (held.verdict === 'not_tested') return held.source ? `Judged on ${held.source}.` : 'Judged on the identification data.';
  return `${{ confirmed: 'Held-out data confirm it', not_confirmed: 'Held-out data do not confirm it' }[held.verdict] ?? words(held.verdict)} (${held.source}).`;
}

function foundIn(result, effort) {
  const { verdict, summary: summed, findings, data_faults: faults } = result.residual;
  const [kind, text] = RESIDUAL[verdict] ?? ['', words(verdict)];
  const none = result.rms.validation.length ? null : ' There was no validation log.';
  const where = (joints) => (joints.length === result.joints.length && joints.length > 1 ? 'all joints' : joints.join(', '));
  const one = (f) => h('li', {}, h('strong', {}, effectName(f), ` on ${where(f.joints)}`), `: ${f.parameters.map((p) => `${f.law ? p.name : words(p.name).toLowerCase()} ${measured(p.value, p.std_dev)} ${unit(p.unit === '1' ? '' : p.unit)}`.trim()).join(', ')}`, gain(f, effort[result.joints.indexOf(f.joints[0])] ?? effort[0]));
  const ordered = byGain(findings).map(([f]) => f);
  const [small, large] = [ordered.filter((f) => f.held_out.change === 'same'), ordered.filter((f) => f.held_out.change !== 'same')];
  return h('div', { class: `notice ${kind === 'good' ? 'good' : ''}`, id: 'verdict' }, h('p', {}, h('strong', {}, said(summed ?? text))), h('p', {}, said(scope(result.residual)), none), faults.map((f) => h('p', {}, said(`${sentence(f.detail)} ${f.remedy}`))),
    large.length ? h('ul', { class: 'list' }, large.map(one)) : null,
    small.length ? h('details', {}, h('summary', {}, `${small.length === 1 ? 'One effect' : `${small.length} effects`} without a significant change of the held-out error`), h('ul', { class: 'list' }, small.map(one))) : null,
    h('p', {}, h('a', { class: 'button primary', id: 'to-loop', href: `/loop?id=${result.id}` }, 'See the diagnosis')));
}

/** Effects beside the base parameters, one estimate with them. */
function effectsFound(result) {
  const rows = result.effects.flatMap((e) => e.parameters.map((p) => ({ ...e, p })));
  if (!rows.length) return null;
  return section('effects', [term('effect', 'Effects'), ' beside the declared model'], h('p', { class: 'soft' }, 'Estimated together with the base parameters.'), table([
    { head: 'Effect', term: 'effect', cell: (r) => effectName(r), sort: (r) => r.effect }, { head: 'Joints', cell: (r) => (r.joints.length === result.joints.length && r.joints.length > 1 ? 'all' : r.joints.join(', ')) },
    { head: 'Parameter', cell: (r) => parameterName(r, r.p.name) }, { head: 'Value', number: true, cell: (r) => `${measured(r.p.value, r.p.std_dev)} ${unit(r.p.unit === '1' ? '' : r.p.unit)}` }, { head: 'In the model', term: 'in_model', cell: (r) => (!r.in_model ? 'no' : r.declared ? 'yes, declared' : r.finding ? 'yes' : 'yes, not significant alone') },
  ], rows, { caption: 'Effects, with one standard deviation' }));
}

function files(result) {
  const model = result.physical_parameters ? [['URDF', 'urdf'], ['MJCF', 'mjcf', 'xml'], ['SDF', 'sdf'], ['C', 'c'], ['Python', 'python', 'py'], ['CSV', 'csv'], ['Model (JSON)', 'json']].map(([label, format, ending = format]) => download(label, `/identify/${result.id}/model?format=${format}`, `model-${result.id}.${ending}`)) : null;
  return h('div', { id: 'downloads' }, h('h3', {}, 'Download'), h('div', { class: 'row' }, reportLink(result, 'Report (HTML)'), model, download('Result (JSON)', `/identify/${result.id}`, `identification-${result.id}.json`)));
}

/** The report opens in a tab of its own; with a token it is fetched with it and saved. */
export function reportLink(result, label) {
  const address = `/identify/${result.id}/report`;
  const link = h('a', { class: 'button', id: 'report', href: address, target: '_blank', rel: 'noopener' }, label);
  link.addEventListener('click', async (event) => {
    if (!token()) return;
    event.preventDefault();
    save(await (await send(address)).blob(), `report-${result.id}.html`);
  });
  return link;
}

/** What the errors are of. */
function whichErrors(result) {
  const effects = result.effects.filter((e) => e.in_model && e.finding).length;
  const nuisance = result.effects.filter((e) => e.in_model && !e.finding && !e.declared).length;
  return `Of single measurements, noise included, for the model ${effects ? `with the ${effects === 1 ? 'effect' : `${effects} effects`} found${nuisance ? ` and ${nuisance} further torque ${nuisance === 1 ? 'offset' : 'offsets'}` : ''}; “declared” is the model without, estimated from the same rows with the same weights.` : 'as estimated.'}`;
}

function errors(result, effort) {
  const found = result.effects.some((e) => e.in_model);
  const declared = (role, i) => (found ? result.declared.rms[role][i].base : null);
  const rows = ['identification', 'validation'].flatMap((role) => result.rms[role].flatMap((log, i) =>
    [['declared', declared(role, i)], ['base', log.base], ['physical', log.physical]].filter(([, e]) => e).map(([model, e]) => ({ role, log: log.name, model, ...e }))));
  const short = shortNames(result.joints);
  const joint = (name, j) => ({ head: `${short[j]} (${effort[j]})`, own: true, number: true, cell: (r) => h('span', { title: `${number(r.percent[j], 3)} % of its own RMS` }, number(r.rms[j], 3), h('br'), h('small', { class: 'soft' }, `${number(r.percent[j], 2)} %`)), sort: (r) => r.rms[j] });
  const none = result.rms.validation.length ? null : h('div', { class: 'notice' }, h('p', {}, 'There was no validation log: these are errors on the identification data.'));
  return section('errors', [term('rms_error', 'Errors'), ' per joint'], none, h('p', { class: 'soft' }, 'Root mean square of measured less predicted torque; below it the share of the torque’s own root mean square.'), h('p', { class: 'soft', id: 'which-errors' }, whichErrors(result)),
    table([{ head: 'Log', cell: (r) => r.log, sort: (r) => r.log }, { head: 'Role', term: 'log_role', cell: (r) => r.role, sort: (r) => r.role }, { head: 'Model', term: 'declared_model', cell: (r) => r.model, sort: (r) => r.model }, ...result.joints.map(joint), { head: 'Sum', number: true, cell: (r) => number(r.sum, 3), sort: (r) => r.sum }], rows, { caption: 'RMS errors' }),
    h('h3', {}, 'Noise'), table([
      { head: 'Joint', cell: (n) => n.joint, sort: (n) => n.joint }, { head: 'Residual RMS', term: 'rms_error', number: true, cell: (n) => number(n.residual_rms, 3), sort: (n) => n.residual_rms },
      { head: 'Noise', number: true, cell: (n) => number(n.noise_std, 3), sort: (n) => n.noise_std, term: 'noise_floor' }, { head: 'Lack of fit', number: true, cell: (n) => number(n.misfit, 3), sort: (n) => n.misfit, term: 'lack_of_fit' },
      { head: 'Rows', term: 'rows', number: true, cell: (n) => n.rows.toLocaleString(), sort: (n) => n.rows }, { head: 'Effective rows', number: true, cell: (n) => number(n.effective_rows, 3), sort: (n) => n.effective_rows, term: 'rows' },
    ], result.noise, { caption: 'Noise of the fitted rows, per joint' }));
}

function logs(result) {
  const one = (log) => h('div', {}, h('h3', {}, log.file), h('p', { class: 'soft' }, `${log.rows_used.toLocaleString()} of ${log.rows.toLocaleString()} rows, ${number(log.sample_rate_hz)} Hz, ${number(log.duration_s)} s, ${log.role}`),
    log.findings.length ? h('div', { class: 'notice' }, log.findings.map((f) => h('p', {}, h('strong', {}, faultName(f.code)), `, ${f.count}: `, said(f.detail)))) : null,
    h('details', {}, h('summary', {}, 'Preparation'), table([{ head: 'Step', term: 'preparation', cell: (c) => step(c.what) }, { head: 'Choice', cell: (c) => c.value }, { head: 'Reason', cell: (c) => said(c.why) }], log.choices, { caption: 'Decisions of the preparation' })));
  const origin = result.provenance ? h('details', {}, h('summary', {}, 'Reproduction'), table([{ head: 'File', cell: (l) => l.file }, { head: 'Bytes', number: true, cell: (l) => l.bytes.toLocaleString() }, { head: 'SHA-256', term: 'checksum', cell: (l) => h('span', { class: 'mono' }, l.sha256) }], result.provenance.logs, { caption: `dynident ${result.provenance.version}` }),
    h('pre', { tabindex: 0 }, JSON.stringify(result.provenance.request, null, 1))) : null;
  return section('logs', 'Logs', result.log_report.map(one), origin);
}
