from math import ceil, cos, exp, fabs, floor, log, pow, sin, sqrt, tan, tanh

@TABLES@@CHANNEL_HELPER@

def sign(x):
    return (x > 0) - (x < 0)


def clamp(x):
    return max(-1.0, min(1.0, x))


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _times(a, b):
    return [row[0] * b[0] + row[1] * b[1] + row[2] * b[2] for row in a]


def _transposed_times(a, b):
    return [a[0][i] * b[0] + a[1][i] * b[1] + a[2][i] * b[2] for i in range(3)]


def _sum(*vectors):
    return [sum(parts) for parts in zip(*vectors)]


def _rigid_body(q, qd, qdd, gravity):
    """Torques of the bodies by recursive Newton-Euler (Luh, Walker, Paul 1980)."""
    w, dw, a = [0.0] * 3, [0.0] * 3, [-g for g in gravity]
    rotations, shifts, forces, moments = [], [], [], []
    for k in range(N):
        s, c = (sin(q[k]), cos(q[k])) if REVOLUTE[k] else (0.0, 1.0)
        slide = 0.0 if REVOLUTE[k] else q[k]
        rotation = [(c * x + s * y, c * y - s * x, z) for x, y, z in ROTATION[k]]
        shift = [t + slide * row[2] for t, row in zip(TRANSLATION[k], ROTATION[k])]
        a = _transposed_times(rotation, _sum(a, _cross(dw, shift), _cross(w, _cross(w, shift))))
        w, dw = _transposed_times(rotation, w), _transposed_times(rotation, dw)
        if REVOLUTE[k]:
            dw = [dw[0] + w[1] * qd[k], dw[1] - w[0] * qd[k], dw[2] + qdd[k]]
            w = [w[0], w[1], w[2] + qd[k]]
        else:
            a = [a[0] + 2.0 * w[1] * qd[k], a[1] - 2.0 * w[0] * qd[k], a[2] + qdd[k]]
        h = MOMENT[k]
        forces.append(_sum([MASS[k] * x for x in a], _cross(dw, h), _cross(w, _cross(w, h))))
        moments.append(_sum(_times(INERTIA[k], dw), _cross(w, _times(INERTIA[k], w)), _cross(h, a)))
        rotations.append(rotation)
        shifts.append(shift)
    tau = [0.0] * N
    for k in range(N - 1, -1, -1):
        tau[k] = moments[k][2] if REVOLUTE[k] else forces[k][2]
        if k > 0:
            f = _times(rotations[k], forces[k])
            forces[k - 1] = _sum(forces[k - 1], f)
            moments[k - 1] = _sum(moments[k - 1], _times(rotations[k], moments[k]), _cross(shifts[k], f))
    return tau


def _torques(q, qd, qdd, rigid@CHANNELS@):
    """Torque of the joints beside that of the bodies, for the true position, velocity and acceleration of the motors."""
    declared = [t + fv * v + fs * sign(v) for t, fv, fs, v in zip(rigid, VISCOUS, COULOMB, qd)]
    tau = list(declared)
@EFFECTS@    return [g * t for g, t in zip(GAIN, tau)]


def inverse_dynamics(q, qd, qdd@CHANNELS@):
    """Torque of the joints, N values, for N positions, velocities and accelerations."""
    q, qd, qdd = ([float(x) for x in values] for values in (q, qd, qdd))
    q = [x + o for x, o in zip(q, OFFSET)]
    return _torques(q, qd, qdd, _rigid_body(q, qd, qdd, GRAVITY)@PASS@)


def gravity(q@CHANNELS@):
    """Torque that holds the arm still, N values."""
    return inverse_dynamics(q, [0.0] * N, [0.0] * N@PASS@)


def mass_matrix(q@CHANNELS@):
    """N rows of N values."""
    q = [float(x) + o for x, o in zip(q, OFFSET)]
    columns = [_rigid_body(q, [0.0] * N, [float(i == c) for i in range(N)], (0.0, 0.0, 0.0)) for c in range(N)]
    r = [[column[i] for column in columns] for i in range(N)]
    m = [list(row) for row in r]
@MASS@    return [[g * x for x in row] for g, row in zip(GAIN, m)]
@MEMORY_PART@