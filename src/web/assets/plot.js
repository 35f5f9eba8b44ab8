// Plots: plotly.js with the colours of the page, units on every axis, and long series thinned without losing their peaks.
import { shortNames } from './dom.js';

/** Okabe and Ito's colours, which people with any kind of colour vision tell apart, and a dash each for those who see none. */
const COLOURS = {
  light: ['#0072b2', '#d55e00', '#009e73', '#b3589b', '#b07d00', '#3a9ad1', '#222222'],
  dark: ['#4da6dd', '#ff8a3d', '#2fc79a', '#e39bc8', '#e8c04a', '#9bd4f5', '#f2f2f2'],
};
const DASHES = ['solid', 'dash', 'dot', 'dashdot', 'longdash', '8px 3px', '2px 4px'];

export const isDark = () => getComputedStyle(document.documentElement).colorScheme === 'dark';
export const variable = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
export const colour = (index) => COLOURS[isDark() ? 'dark' : 'light'][index % 7];
export const dash = (index) => DASHES[index % 7];

let loading = null;
/** plotly.js, fetched when the first plot asks for it, or before by pages that wait for what they will plot. */
export function plotly() {
  loading ??= new Promise((done, failed) => {
    const script = document.createElement('script');
    script.src = '/assets/plotly.js';
    script.onload = () => done(window.Plotly);
    script.onerror = () => failed(new Error('plotly.js could not be loaded'));
    document.head.append(script);
  });
  return loading;
}

const drawn = new Map();
/** Plots that wait for being scrolled to. */
const waiting = new Map();
/** Points across a printed page of A4, less its margins. */
const PAPER = 660;
addEventListener('beforeprint', () => {
  waiting.forEach((now) => now());
  drawn.forEach((_, place) => place.isConnected && place.data && window.Plotly.relayout(place, { width: Math.min(PAPER, place.clientWidth || PAPER), autosize: false }));
});
addEventListener('afterprint', () => drawn.forEach((_, place) => place.isConnected && place.data && window.Plotly.relayout(place, { width: null, autosize: true })));
document.addEventListener('theme', () => drawn.forEach((draw) => draw()));

/** Whether a plot is as narrow as on a phone: its legend is below, and it is higher. */
const isNarrow = (place) => place.clientWidth < 520;
/** A phone that is turned has plots of the other kind. */
addEventListener('resize', () => drawn.forEach((draw, place) => place.dataset.narrow !== String(isNarrow(place)) && place.clientWidth > 0 && draw()));

/**
 * Draws a plot into `place`, again after a change of theme. `make()` hands back `{traces, layout}`: called anew, because colours
 * belong to the theme.
 */
export async function plot(place, make, options = {}) {
  // At once where it is there: a page that is printed waits for nothing.
  const Plotly = window.Plotly ?? await plotly();
  const draw = () => {
    const { traces, layout } = make();
    shortenPlaces(traces, layout);
    const full = dressed(layout, place, traces);
    // Otherwise plotly.js leaves the place as high as it was first.
    place.style.height = full.height ? `${full.height}px` : null;
    place.dataset.narrow = isNarrow(place);
    return Plotly.react(place, traces, full, { responsive: true, displaylogo: false, modeBarButtonsToRemove: ['lasso2d', 'select2d'], ...options });
  };
  if (place.dataset.label) {
    place.setAttribute('role', 'img');
    place.setAttribute('aria-label', place.dataset.label);
  }
  drawn.set(place, () => place.isConnected ? draw() : drawn.delete(place));
  return draw();
}

/** As `plot`, once the place comes near the screen: pages with many plots open at once. */
export function plotLater(place, make, options) {
  const watch = new IntersectionObserver((entries) => {
    if (entries.some((e) => e.isIntersecting)) now();
  }, { rootMargin: '400px' });
  const now = () => {
    watch.disconnect();
    waiting.delete(place);
    if (place.isConnected) plot(place, make, options);
  };
  waiting.set(place, now);
  watch.observe(place);
}

/** Long names of joints below an axis leave no room for what is drawn: they are shown without what all have in common. */
function shortenPlaces(traces, layout) {
  if (layout.xaxis?.type !== 'category' || layout.xaxis.ticktext) return;
  const names = [...new Set(traces.flatMap((t) => t.x ?? []))].map(String);
  const short = shortNames(names);
  if (short !== names) layout.xaxis = { ...layout.xaxis, tickvals: names, ticktext: short };
}

function dressed(layout, place, traces) {
  const [ink, soft, grid] = ['--ink', '--soft', '--grid'].map(variable);
  const narrow = isNarrow(place);
  const explained = traces.length > 1 || traces.some((t) => t.showlegend);
  const axis = { gridcolor: grid, linecolor: soft, zerolinecolor: grid, ticks: 'outside', ticklen: 4, exponentformat: 'power', tickcolor: grid, automargin: true, title: { standoff: 8 } };
  // On a phone the top belongs to the buttons that zoom, the legend goes below.
  const legend = narrow ? { orientation: 'h', y: 0, yref: 'container', yanchor: 'bottom', x: 0 } : { orientation: 'h', y: 1.02, yanchor: 'bottom', x: 0 };
  const full = {
    paper_bgcolor: 'rgba(0,0,0,0)', plot_bgcolor: 'rgba(0,0,0,0)', font: { family: 'system-ui, sans-serif', size: narrow ? 11 : 12.5, color: ink },
    margin: { l: narrow ? 48 : 64, r: narrow ? 8 : 18, t: narrow ? 34 : 12, b: 44 }, hovermode: 'x unified', hoverlabel: { bgcolor: variable('--card'), font: { color: ink } },
    modebar: { bgcolor: 'rgba(0,0,0,0)', color: soft }, dragmode: narrow ? false : 'zoom',
    ...layout,
  };
  full.legend = { ...legend, ...layout.legend };
  // Room for a legend below, where there is one.
  if (narrow) Object.assign(full, { height: (layout.height ?? 300) + (explained ? 60 : 10), margin: { ...full.margin, b: explained ? 96 : 46 } });
  for (const name of Object.keys(full).concat(['xaxis', 'yaxis']).filter((k) => /^[xy]axis/.test(k))) {
    const own = full[name] ?? {};
    // Few figures on logarithmic axes: 1, 2, 5 at most.
    full[name] = { ...axis, ...(own.type === 'log' ? { nticks: 3, tickformat: '~g' } : {}), ...own, title: { ...axis.title, ...(typeof own.title === 'string' ? { text: own.title } : own.title) } };
  }
  return full;
}

/**
 * At most about `most` indices of `y` between `from` and `to` (indices): the lowest and the highest of every bucket, so that no peak is lost.
 */
export function thin(y, most, from = 0, to = y.length) {
  const count = to - from;
  if (count <= most) return Array.from({ length: count }, (_, i) => from + i);
  const picked = [];
  const buckets = Math.max(1, Math.floor(most / 2));
  for (let b = 0; b < buckets; b += 1) {
    const [start, end] = [from + Math.floor((b * count) / buckets), from + Math.floor(((b + 1) * count) / buckets)];
    let [low, high] = [start, start];
    for (let i = start; i < end; i += 1) {
      if (y[i] < y[low]) low = i;
      if (y[i] > y[high]) high = i;
    }
    picked.push(Math.min(low, high));
    if (low !== high) picked.push(Math.max(low, high));
  }
  return picked;
}

/** Mean steps of a series after which it has a gap: thinned ones have steps of up to four. */
const GAP = 8;
/** Indices at which a series goes on after a gap, such as rows that the fit leaves out: a line across it would be no measurement. */
export function gaps(x) {
  const longest = GAP * ((x.at(-1) - x[0]) / (x.length - 1));
  return x.flatMap((v, i) => (i && v - x[i - 1] > longest ? [i] : []));
}

/** Coordinates at `picked` indices of a series, with an empty point in every gap. */
function broken(x, y, picked, breaks) {
  const [xs, ys] = [[], []];
  let next = 0;
  picked.forEach((i, k) => {
    while (next < breaks.length && breaks[next] <= (picked[k - 1] ?? -1)) next += 1;
    if (k && next < breaks.length && breaks[next] <= i) {
      xs.push(x[breaks[next] - 1]);
      ys.push(null);
    }
    xs.push(x[i]);
    ys.push(y[i]);
  });
  return { x: xs, y: ys };
}

/**
 * A time plot of long series: thinned to what the screen shows, anew at every zoom. `series`: {x, y, trace}, x ascending.
 */
export async function plotLong(place, series, layout) {
  const most = 2400;
  const at = new Map(series.map(({ x }) => [x, gaps(x)]));
  let range = null;
  const bound = (x, value) => {
    let [low, high] = [0, x.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (x[middle] < value) low = middle + 1; else high = middle;
    }
    return low;
  };
  const make = () => {
    const traces = series.map(({ x, y, trace }) => {
      const [from, to] = range ? [Math.max(0, bound(x, range[0]) - 1), Math.min(x.length, bound(x, range[1]) + 1)] : [0, x.length];
      const breaks = at.get(x).filter((i) => i > from && i < to);
      const picked = thin(y, Math.max(most - breaks.length, most / 2), from, to);
      return { type: 'scatter', mode: 'lines', ...trace(), ...broken(x, y, picked, breaks) };
    });
    const made = layout();
    // A copy: plotly.js writes the next range into what it was given, which would then look like no change.
    if (range) made.xaxis = { ...made.xaxis, range: [...range] };
    return { traces, layout: made };
  };
  await plot(place, make);
  place.on('plotly_relayout', (change) => {
    const wanted = change['xaxis.autorange'] ? null : [change['xaxis.range[0]'] ?? change['xaxis.range']?.[0], change['xaxis.range[1]'] ?? change['xaxis.range']?.[1]];
    if (wanted && wanted[0] === undefined) return;
    if (JSON.stringify(wanted) === JSON.stringify(range)) return;
    range = wanted;
    plot(place, make);
  });
}
