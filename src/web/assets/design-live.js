// A search as it goes: one line per random start, and the best so far.
import { short, shown, title } from './criteria.js';
import { fill, h, number, seconds } from './dom.js';
import { on } from './known-form.js';
import { colour, plot } from './plot.js';

export class Live {
  constructor(place, cancel) {
    Object.assign(this, { place, cancel, best: [], starts: [], criterion: null, due: 0, timer: null });
  }

  /** `asked`: the request, where this browser made it. */
  begin(job, asked) {
    this.place.hidden = false;
    this.figures = h('dl', { class: 'figures', 'aria-live': 'off' });
    this.charts = [
      h('div', { class: 'plot', 'data-label': 'Random starts: the criterion over the evaluations of each, one line per start' }),
      h('div', { class: 'plot', 'data-label': 'The best value of the criterion so far, over all evaluations' }),
    ];
    const stop = h('button', { type: 'button', onclick: () => { stop.disabled = true; stop.textContent = 'Ending …'; this.cancel(); } }, 'Stop and keep the best');
    const pair = asked?.rivals?.finding?.effect ? asked.rivals : null;
    const about = [`One line per random start: from where it began, ${pair ? 'up' : 'down'} its own slope.`, 'The best of all. Later searches start from the best points found, and exchange joints between them.'];
    fill(this.place, h('div', { class: 'row spread' }, h('h2', { id: 'live-title' }, job.state === 'queued' ? 'Waiting for its turn' : 'Searching'), stop),
      pair ? h('p', {}, 'This motion distinguishes ', h('strong', {}, `${on(pair.finding)}, or ${on(pair.rival)}`), '. The search maximises the expected difference in BIC between them.') : null, this.figures,
      h('div', { class: 'halves' }, this.charts.map((chart, i) => h('div', {}, chart, h('p', { class: 'help' }, about[i])))));
  }

  show(job) {
    const p = job.progress;
    this.place.querySelector('h2').textContent = { queued: 'Waiting for its turn', running: 'Searching' }[job.state] ?? 'Done';
    if (!p) return;
    this.criterion = p.criterion;
    if (p.best !== null) this.best.push([p.evaluations, shown(p.criterion, p.best)]);
    this.starts.push(...(p.ended ?? []).filter((s) => s.course?.length > 1).map((s) => s.course));
    const figure = (name, value, data) => h('div', { class: 'figure' }, h('dt', {}, name), h('dd', { 'data-best': data }, value));
    fill(this.figures, figure(`${title(p.criterion)}, best so far`, number(shown(p.criterion, p.best)), p.best), figure('Starts', p.starts_finished),
      figure('Evaluations', p.evaluations.toLocaleString()), figure('Time', seconds(p.elapsed_s)));
    this.drawSoon();
  }

  /** A few times a second: more is not seen and costs the search its processor. */
  drawSoon() {
    if (this.timer) return;
    this.timer = setTimeout(() => {
      this.timer = null;
      if (this.place.hidden) return;
      plot(this.charts[0], () => courses(this.starts, this.criterion));
      plot(this.charts[1], () => this.falling());
    }, Math.max(0, this.due - performance.now()));
    this.due = performance.now() + 400;
  }

  falling() {
    return {
      traces: [{ x: this.best.map((b) => b[0]), y: this.best.map((b) => b[1]), type: 'scatter', mode: 'lines', line: { color: colour(1), width: 3, shape: 'hv' }, showlegend: false, hovertemplate: '%{y:.4g}<extra></extra>' }],
      layout: { height: 290, hovermode: 'x', xaxis: { title: 'all evaluations of the criterion', rangemode: 'tozero', exponentformat: 'none', nticks: 5 }, yaxis: { title: `${short(this.criterion)}, best so far`, type: 'log' } },
    };
  }

  end() {
    clearTimeout(this.timer);
    this.place.hidden = true;
  }
}

/** One line per random start; the one that came lowest stands out. */
export function courses(starts, criterion) {
  const worth = (course) => course.map((p) => [p[0], shown(criterion, p[1])]);
  const last = starts.map((course) => course.at(-1)[1]);
  const best = last.indexOf(Math.min(...last));
  const [x, y] = [[], []];
  for (const course of starts.filter((_, i) => i !== best)) {
    for (const [n, value] of worth(course)) {
      x.push(n);
      y.push(value);
    }
    // A gap: the next start is another line.
    x.push(null);
    y.push(null);
  }
  const front = best < 0 ? [] : worth(starts[best]);
  return {
    traces: [
      { x, y, type: 'scatter', mode: 'lines', name: 'random starts', line: { color: colour(5), width: 1 }, opacity: 0.75, hoverinfo: 'skip' },
      { x: front.map((p) => p[0]), y: front.map((p) => p[1]), type: 'scatter', mode: 'lines', name: 'the best of them', line: { color: colour(0), width: 2.5 }, hovertemplate: '%{y:.4g}<extra></extra>' },
    ],
    layout: { height: 290, hovermode: 'closest', xaxis: { title: 'evaluations of each start', rangemode: 'tozero' }, yaxis: { title: short(criterion), type: 'log' } },
  };
}
