// Base parameters with error bars and as a table that sorts.
import { h, measured, number, said, table, term, unit } from './dom.js';
import { nameOf, typeset } from './expression.js';
import { colour, plot, plotLater } from './plot.js';

export function parameters(result) {
  const all = [...result.base_parameters, ...(result.offsets ?? [])];
  const kinds = [...new Set(all.map((p) => p.unit))];
  const kind = h('select', { class: 'narrow', id: 'parameter-unit' }, kinds.map((k) => h('option', { value: k }, `${unit(k)} (${all.filter((p) => p.unit === k).length})`)));
  const chart = h('div', { class: 'plot', 'data-label': 'Values of the base parameters with two standard deviations either side' });
  const make = () => {
    const shown = all.filter((p) => p.unit === kind.value && p.value !== null);
    return {
      traces: [{ type: 'scatter', mode: 'markers', x: shown.map((p) => p.name), y: shown.map((p) => p.value), marker: { color: colour(0), size: 8 }, error_y: { type: 'data', array: shown.map((p) => 2 * p.std_dev), color: colour(1), thickness: 2, width: 5 },
        hovertemplate: shown.map((p) => `${p.name} = ${measured(p.value, p.std_dev)} ${unit(p.unit)}<extra></extra>`) }],
      layout: { height: 320, hovermode: 'closest', xaxis: { type: 'category', tickangle: -90, title: 'base parameter' }, yaxis: { title: `value ± 2σ (${unit(kind.value)})`, zeroline: true } },
    };
  };
  kind.addEventListener('change', () => plot(chart, make));
  plotLater(chart, make);
  const open = result.undetermined.length ? h('div', { class: 'notice' }, h('p', {}, h('strong', {}, 'Not determined by the log: '), said(result.undetermined.map((d) => d.text).join('; ')))) : null;
  return h('section', { class: 'card', id: 'parameters', 'aria-labelledby': 'parameters-title' }, h('div', { class: 'row spread' }, h('h2', { id: 'parameters-title' }, term('base_parameters', 'Base parameters')), h('label', { class: 'inline' }, 'Unit', kind)), open, chart,
    table([
      { head: 'Parameter', term: 'base_parameters', cell: (p) => nameOf(p.name), sort: (p) => p.name },
      { head: 'Value', number: true, cell: (p) => (p.value === null ? 'not determined' : `${number(p.value)} ${unit(p.unit)}`), sort: (p) => p.value },
      { head: 'σ', number: true, cell: (p) => number(p.std_dev, 2), sort: (p) => p.std_dev, term: 'std_dev' },
      { head: 'σ/|value|', term: 'relative_std_dev', number: true, cell: (p) => (p.relative_std_dev_percent === null ? '–' : `${number(p.relative_std_dev_percent, 3)} %`), sort: (p) => p.relative_std_dev_percent },
      { head: 'Textbook', number: true, cell: (p) => (p.textbook_relative_std_dev_percent === null ? '–' : `${number(p.textbook_relative_std_dev_percent, 3)} %`), sort: (p) => p.textbook_relative_std_dev_percent, term: 'textbook' },
      { head: 'Expression', term: 'standard_parameters', cell: (p) => typeset(p.expression) },
    ], all, { caption: 'Identified parameters', sort: { column: 3, way: 'ascending' } }));
}
