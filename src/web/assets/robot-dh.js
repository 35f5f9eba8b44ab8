// Denavit-Hartenberg tables in their three conventions, as the placements of a robot description (Khalil's modified parameters).

/** The columns of a row in each convention: name, and whether it is an angle. `joint` is the row's own variable that q is added to. */
export const CONVENTIONS = {
  khalil: { name: 'Modified, Khalil', columns: [['alpha', 'α', true], ['a', 'd', false], ['theta', 'θ', true], ['d', 'r', false]],
    help: 'Row j leads from frame j−1 to frame j: Rot x(α) · Trans x(d) · Rot z(θ) · Trans z(r).' },
  craig: { name: 'Modified, Craig', columns: [['alpha', 'αᵢ₋₁', true], ['a', 'aᵢ₋₁', false], ['theta', 'θᵢ', true], ['d', 'dᵢ', false]],
    help: 'The same as Khalil’s in other letters: Rot x(αᵢ₋₁) · Trans x(aᵢ₋₁) · Rot z(θᵢ) · Trans z(dᵢ).' },
  standard: { name: 'Standard (distal)', columns: [['theta', 'θᵢ', true], ['d', 'dᵢ', false], ['a', 'aᵢ', false], ['alpha', 'αᵢ', true]],
    help: 'Rot z(θᵢ) · Trans z(dᵢ) · Trans x(aᵢ) · Rot x(αᵢ), as in most data sheets. The last a and α place the flange only; they move no mass and are left out.' },
};

/**
 * Khalil's parameters {alpha, d, theta, r} of every row {alpha, a, theta, d} (rad, m). A standard row turns about the axis before it and ends with a and
 * α, which are therefore the first half of the next modified row.
 */
export function modified(rows, convention) {
  const before = (j) => (convention === 'standard' ? rows[j - 1] ?? { alpha: 0, a: 0 } : rows[j]);
  return rows.map((row, j) => ({ alpha: before(j).alpha, d: before(j).a, theta: row.theta, r: row.d }));
}

/** A description to start from; gravity along −z, limits to be filled in. */
export const robotOf = (name, rows, convention) => ({
  name, gravity: [0, 0, -9.81], friction: ['viscous', 'coulomb'],
  joints: modified(rows, convention).map((mdh, j) => ({ name: rows[j].name, kind: rows[j].kind, mdh, limits: { position: null, velocity: null, acceleration: null, jerk: null, effort: null } })),
});
