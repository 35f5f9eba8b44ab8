// A search as it goes: the best value so far, and one line per start.
import { fill, h, number, seconds } from './dom.js';
import { colour, plot } from './plot.js';

export class Live {
  constructor(place, cancel) {
    Object.assign(this, { place, cancel, best: [], starts: [], due: 0, timer: null });
  }

  begin(job) {
    this.place.hidden = false;
    this.figures = h('dl', { class: 'figures', 'aria-live': 'off' });
    this.chart = h('div', { class: 'plot', 'data-label': 'Value of the criterion over the evaluations: a line for each random start, and the best so far' });
    const stop = h('button', { type: 'button', onclick: () => { stop.disabled = true; stop.textContent = 'Ending …'; this.cancel(); } }, 'Stop and keep the best');
    fill(this.place, h('div', { class: 'row spread' }, h('h2', { id: 'live-title' }, job.state === 'queued' ? 'Waiting for its turn' : 'Searching'), stop), this.figures, this.chart,
      h('p', { class: 'help' }, 'Thin lines: random starts, from where each began to what its local search reached. Thick: the best trajectory so far, which later searches start from.'));
  }

  show(job) {
    const p = job.progress;
    this.place.querySelector('h2').textContent = { queued: 'Waiting for its turn', running: 'Searching' }[job.state] ?? 'Done';
    if (!p) return;
    if (p.best !== null) this.best.push([p.evaluations, p.best]);
    for (const s of (p.ended ?? []).filter((s) => s.reached !== null)) this.starts.push([Math.max(p.evaluations - s.evaluations, 0), p.evaluations, s.initial, s.reached]);
    fill(this.figures, h('div', { class: 'figure' }, h('dt', {}, 'Best so far'), h('dd', { 'data-best': p.best }, number(p.best))),
      h('div', { class: 'figure' }, h('dt', {}, 'Starts'), h('dd', {}, p.starts_finished)), h('div', { class: 'figure' }, h('dt', {}, 'Evaluations'), h('dd', {}, p.evaluations.toLocaleString())),
      h('div', { class: 'figure' }, h('dt', {}, 'Time'), h('dd', {}, seconds(p.elapsed_s))));
    this.drawSoon();
  }

  /** A few times a second: more is not seen and costs the search its processor. */
  drawSoon() {
    if (this.timer) return;
    this.timer = setTimeout(() => {
      this.timer = null;
      if (!this.place.hidden) plot(this.chart, () => this.picture());
    }, Math.max(0, this.due - performance.now()));
    this.due = performance.now() + 400;
  }

  picture() {
    const [x, y] = [[], []];
    for (const [from, to, initial, reached] of this.starts) {
      x.push(from, to, null);
      y.push(initial ?? reached, reached, null);
    }
    const traces = [
      { x, y, type: 'scatter', mode: 'lines+markers', name: 'random starts', line: { color: colour(5), width: 1 }, marker: { size: 3 }, hoverinfo: 'skip' },
      { x: this.best.map((b) => b[0]), y: this.best.map((b) => b[1]), type: 'scatter', mode: 'lines', name: 'best so far', line: { color: colour(1), width: 3, shape: 'hv' } },
    ];
    return { traces, layout: { xaxis: { title: 'evaluations of the criterion', rangemode: 'tozero' }, yaxis: { title: 'criterion (lower is better)', type: 'log' }, height: 300, hovermode: 'x' } };
  }

  end() {
    clearTimeout(this.timer);
    this.place.hidden = true;
  }
}
