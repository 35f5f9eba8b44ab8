// Physical parameters: bodies on the arm, a table, margins to what is possible.
import { ArmView, ellipsoid, HOW_TO_TURN } from './arm.js';
import { h, number, table, term, words } from './dom.js';
import { colour, plotLater } from './plot.js';

/** A constraint as people call it. */
const called = (constraint) => (constraint === 'center_of_mass_box' ? 'Box for the centre of mass' : words(constraint));

const turnBack = (m, v) => [0, 1, 2].map((c) => m[0][c] * v[0] + m[1][c] * v[1] + m[2][c] * v[2]);
const matrix = (i) => [[i.xx, i.xy, i.xz], [i.xy, i.yy, i.yz], [i.xz, i.yz, i.zz]];
/** `Tᵀ M T`: from the frame of the description to that of the joint. */
const turnMatrix = (t, m) => [0, 1, 2].map((r) => [0, 1, 2].map((c) => [0, 1, 2].reduce((sum, k) => sum + [0, 1, 2].reduce((s, l) => s + t[k][r] * m[k][l] * t[l][c], 0), 0)));

export function physical(result, drawn) {
  const card = h('section', { class: 'card', id: 'physical', 'aria-labelledby': 'physical-title' }, h('h2', { id: 'physical-title' }, term('physical_parameters', 'Physical parameters')));
  const links = result.physical_parameters;
  if (!links) {
    card.append(h('p', { class: 'soft' }, result.feasibility ? `No physically possible bodies were found (${words(result.feasibility.status).toLowerCase()}).` : 'The request did not ask for them.'));
    return card;
  }
  if (drawn) card.append(bodies(links, drawn));
  const free = h('p', { class: 'soft' }, 'Base parameters determine only combinations of these. Where several bodies fit equally well, the one nearest to the ', term('prior', 'prior'), ' is taken; without a prior, the one nearest to a rod along the link, with its centre of mass in a box around the link.');
  card.append(free, ...tables(links));
  if (result.feasibility) card.append(margins(result.feasibility));
  return card;
}

/** Two tables, as in the report: one of thirteen columns is wider than most windows. */
function tables(links) {
  const link = { head: 'Link', cell: (l) => `${l.link} ${l.name}`, sort: (l) => l.link };
  const column = (head, value, term_, digits = 3) => ({ head, term: term_, number: true, cell: (l) => number(value(l), digits), sort: value });
  return [
    table([link, column('Mass (kg)', (l) => l.mass, null, 4), ...['x', 'y', 'z'].map((axis, i) => column(`Centre of mass ${axis} (m)`, (l) => l.center_of_mass[i])),
      column('Viscous friction', (l) => l.viscous, 'friction'), column('Coulomb friction', (l) => l.coulomb, 'friction')], links, { caption: 'Per link, in the frames of the robot’s description' }),
    table([link, ...['xx', 'yy', 'zz', 'xy', 'xz', 'yz'].map((k) => column(`I${k}`, (l) => l.inertia[k], 'inertia'))], links, { caption: 'Inertia about the centre of mass (kg·m²)' }),
  ];
}

function bodies(links, drawn) {
  const canvas = h('canvas', { class: 'arm', 'aria-label': 'Every link as the solid ellipsoid that has its mass and inertia. Arrow keys turn the view.' });
  const view = new ArmView(canvas, drawn.joints, drawn.gravity);
  view.bodies = links.map((link, j) => {
    const turn = drawn.joints[j].description_frame;
    return { joint: j, centre: turnBack(turn, link.center_of_mass), shape: ellipsoid(link.mass, turnMatrix(turn, matrix(link.inertia))), label: String(link.link) };
  });
  // Bent, so that links on one line can be distinguished.
  view.q = drawn.joints.map((joint, j) => bent(joint, j));
  view.frameArm();
  return h('div', {}, canvas, h('p', { class: 'help' }, 'Each link as the solid ellipsoid of even density with its mass, centre of mass and inertia; the number is the link’s. ', HOW_TO_TURN));
}

function bent(joint, j) {
  const [low, high] = joint.position_limits ?? [-1, 1];
  const wanted = joint.kind === 'prismatic' ? (low + high) / 2 : [0.3, 0.6, 0, -1.2, 0, 0.9, 0][j % 7];
  return Math.min(high, Math.max(low, wanted));
}

/** `pseudo inertia positive definite on links 2, 4 and 5`. */
function byConstraint(active) {
  return [...new Set(active.map((m) => m.constraint))].map((name) => {
    const links = active.filter((m) => m.constraint === name).map((m) => m.link);
    const named = links.length > 1 ? `links ${links.slice(0, -1).join(', ')} and ${links.at(-1)}` : `link ${links[0]}`;
    return `${called(name).toLowerCase()} on ${named}`;
  });
}

function margins(feasibility) {
  const chart = h('div', { class: 'plot flat', 'data-label': 'Margins of physical consistency, per link' });
  const names = [...new Set(feasibility.margins.map((m) => m.constraint))];
  const positive = feasibility.margins.every((m) => m.margin > 0);
  plotLater(chart, () => ({
    traces: names.map((name, i) => {
      const own = feasibility.margins.filter((m) => m.constraint === name);
      return { type: 'scatter', mode: 'markers', name: called(name), x: own.map((m) => `link ${m.link}`), y: own.map((m) => m.margin), marker: { color: colour(i), size: 10, symbol: i }, hovertemplate: `${called(name)}: %{y:.3g}<extra>%{x}</extra>` };
    }),
    layout: { height: 300, hovermode: 'closest', xaxis: { type: 'category', title: 'link' }, yaxis: { type: positive ? 'log' : 'linear', title: 'margin (above 0: consistent)' } },
  }));
  const table_ = table([
    { head: 'Link', number: true, cell: (m) => m.link, sort: (m) => m.link }, { head: 'Constraint', term: 'physical_margin', cell: (m) => called(m.constraint), sort: (m) => m.constraint }, { head: 'Margin', term: 'physical_margin', number: true, cell: (m) => number(m.margin), sort: (m) => m.margin },
    { head: 'Cost in fit', number: true, cell: (m) => (m.active ? `active, ${m.cost_percent < 0.01 ? '< 0.01' : number(m.cost_percent, 2)} %` : '–'), sort: (m) => m.cost_percent ?? -1, term: 'active' },
  ], feasibility.margins, { caption: 'Margins of physical consistency; zero: active', sort: { column: 2, way: 'ascending' } });
  const active = feasibility.margins.filter((m) => m.active);
  const held = active.length ? h('p', { id: 'active-bounds' }, `Active: ${byConstraint(active).join('; ')}. These bounds, and not only the log, determine these bodies; the table gives the cost of each in fit.`) : null;
  return h('div', {}, h('h3', {}, term('physical_margin', 'Margins of physical consistency')), held, chart, h('details', {}, h('summary', {}, 'As a table'), table_));
}
