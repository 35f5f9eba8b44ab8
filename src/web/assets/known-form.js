// What is known already: earlier designs to go on from, models with effects, data that the next log joins.
import { getJson } from './api.js';
import { reached } from './criteria.js';
import { fill, find, h, time, words } from './dom.js';
import { JsonFiles, givenOf, modelOf, trajectoryOf } from './json-files.js';

const MOST = 12;
const ended = (job) => ['finished', 'cancelled'].includes(job.state) && job.outcome !== 'Infeasible';
const called = (code) => words(code).toLowerCase();
/** `torque offset on J2`. */
export const on = (effect) => `${called(effect.effect)} on ${effect.joints.join(', ') || 'the whole robot'}`;

export class Known {
  constructor(changed) {
    Object.assign(this, { changed, pairs: [] });
    const files = (id, read) => new JsonFiles(find(`#${id}`), read, changed);
    this.files = { warmStart: files('warm-start-file', trajectoryOf), model: files('model-file', modelOf), given: files('given-files', givenOf) };
    find('#model').addEventListener('change', () => this.loadRivals().then(changed));
    find('#warm-start').addEventListener('change', () => this.loadWarmStart().then(changed));
  }

  /** Lists what there is for a robot, and chooses again what `wanted` (a request) names. */
  async load(robot, wanted = {}) {
    const { jobs } = await getJson('/jobs');
    const own = jobs.filter((j) => ended(j) && (!j.robot || j.robot === robot));
    const designs = own.filter((j) => j.kind === 'excitation').slice(0, MOST);
    const identified = own.filter((j) => j.kind === 'identification' && j.state === 'finished').slice(0, MOST);
    const model = wanted.model?.identification;
    fill(find('#warm-start'), h('option', { value: '' }, 'none: random starts'), wanted.warm_start ? h('option', { value: 'as-asked', selected: true }, 'as in this request') : null,
      designs.map((j) => h('option', { value: j.id }, `${time(j.finished_at)}${j.progress?.best ? `, ${reached(j.progress)}` : ''}`)));
    this.warmStart = wanted.warm_start;
    // What a request carries in full came from files.
    this.asked = { model: wanted.model?.identification ? undefined : wanted.model, given: (wanted.given ?? []).filter((g) => !g.identification && !g.excitation) };
    const listed = (list, id) => (id && !list.some((j) => j.id === id) ? [{ id, finished_at: null }, ...list] : list);
    // By the name that it was given, or its log: several of one day are alike otherwise.
    const name = (j) => j.name ?? `${j.finished_at ? time(j.finished_at) : 'identification'} · ${j.logs?.[0] ?? j.id.slice(0, 8)}`;
    fill(find('#model'), h('option', { value: '' }, 'none: rigid links and friction'), this.asked.model ? h('option', { value: 'as-asked', selected: true }, 'as in this request') : null, listed(identified, model).map((j) => h('option', { value: j.id, selected: j.id === model }, name(j))));
    const given = new Map((wanted.given ?? []).map((g) => [g.identification ?? g.excitation, g]));
    const periods = (j) => h('label', { class: 'inline' }, h('input', { class: 'cell-number', type: 'number', min: 1, max: 1000, placeholder: '1', 'data-periods': j.id, 'aria-label': `Periods run of the design ${name(j)}`, value: given.get(j.id)?.periods ?? '' }), 'periods');
    const box = (j) => h('label', { class: 'inline' }, h('input', { type: 'checkbox', value: j.id, 'data-kind': j.kind === 'excitation' ? 'excitation' : 'identification', checked: given.has(j.id) }), `${j.kind === 'excitation' ? 'design, as if run:' : 'log of'} ${name(j)}`);
    const choices = [...identified, ...designs.slice(0, 6)];
    const asked = this.asked.given.length ? h('label', { class: 'inline' }, h('input', { type: 'checkbox', id: 'given-asked', checked: true }), 'documents of this request') : null;
    fill(find('#given'), asked, choices.length ? choices.map((j) => h('div', { class: 'row' }, box(j), j.kind === 'excitation' ? periods(j) : null)) : h('p', { class: 'help' }, 'No runs of this robot yet.'));
    await this.loadRivals(wanted.rivals);
  }

  /** Pairs of causes that the chosen identification does not separate. */
  async loadRivals(wanted) {
    const id = find('#model').value;
    this.pairs = [];
    if (id && id !== 'as-asked') {
      const { residual } = await getJson(`/identify/${id}?predictions=false`);
      this.pairs = (residual?.findings ?? []).flatMap((f) => f.rivals.map((r) => ({ finding: { effect: f.effect, joints: f.joints }, rival: { effect: r.effect, joints: r.joints } })));
    }
    if (wanted && !this.pairs.some((p) => JSON.stringify(p) === JSON.stringify(wanted))) this.pairs.unshift(wanted);
    const same = wanted && this.pairs.findIndex((p) => JSON.stringify(p) === JSON.stringify(wanted));
    fill(find('#rivals'), this.pairs.map((p, i) => h('option', { value: i, selected: i === same }, `${on(p.finding)}, or ${on(p.rival)}`)));
    find('#rivals-field').hidden = !this.pairs.length;
  }

  /** The request carries the trajectory itself, not where it is from. */
  async loadWarmStart() {
    const id = find('#warm-start').value;
    if (id === 'as-asked') return;
    this.warmStart = undefined;
    if (!id) return;
    const { coefficients, offset, fundamental_hz } = await getJson(`/excitation/${id}`);
    this.warmStart = { coefficients: { a: coefficients.a, b: coefficients.b }, offset, fundamental_hz };
  }

  /** Fields of a request. */
  value(criterion) {
    const run = (id) => find(`[data-periods="${id}"]`)?.value;
    const chosen = [...find('#given').querySelectorAll('input[data-kind]:checked')].map((c) => ({ [c.dataset.kind]: c.value, periods: run(c.value) ? Number(run(c.value)) : undefined }));
    const { files, asked } = this;
    const given = [...chosen, ...(files.given.list.length ? files.given.list : find('#given-asked')?.checked ? asked.given : [])];
    return {
      warm_start: files.warmStart.list[0] ?? this.warmStart, model: files.model.list[0] ?? (find('#model').value === 'as-asked' ? asked.model : find('#model').value ? { identification: find('#model').value } : undefined),
      rivals: criterion === 'rival_evidence' ? this.pairs[find('#rivals').value] : undefined, given: given.length ? given : undefined,
    };
  }
}
