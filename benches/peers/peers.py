"""Peers that are called from Python, on the same robot and motion: `python peers.py ROBOT.urdf SAMPLES ROUNDS`. Prints a line per kernel: name, then its
rounds; a line `skipped NAME: reason` for what is not installed."""

import sys
import time

import numpy as np

URDF, SAMPLES, ROUNDS = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])


def rounds(name, per, work, repeats=3):
    times = []
    for _ in range(ROUNDS):
        best = np.inf
        for _ in range(repeats):
            begun = time.perf_counter()
            work()
            best = min(best, time.perf_counter() - begun)
        times.append(1e6 * best / per)
    print(name, *times, flush=True)


def motion(n):
    phase = np.arange(n)[None, :] + 0.01 * np.arange(SAMPLES)[:, None]
    return np.sin(phase), np.cos(phase), -np.sin(phase)


def pinocchio():
    import pinocchio as pin

    model = pin.buildModelFromUrdf(URDF)
    data = model.createData()
    samples = list(zip(*motion(model.nv)))
    rounds("python_inverse_dynamics", SAMPLES, lambda: [pin.rnea(model, data, *s) for s in samples])
    rounds("python_regressor", SAMPLES, lambda: [pin.computeJointTorqueRegressor(model, data, *s) for s in samples])


def figaroh():
    import pinocchio as pin
    from figaroh.tools.regressor import build_regressor_basic

    class Robot:
        model = pin.buildModelFromUrdf(URDF)

    Robot.data = Robot.model.createData()
    config = {"has_friction": False, "has_actuator_inertia": False, "has_joint_offset": False, "is_joint_torques": True, "is_external_wrench": False, "act_idxv": list(range(Robot.model.nv))}
    q, v, a = motion(Robot.model.nv)
    rounds("figaroh_regressor", SAMPLES, lambda: build_regressor_basic(Robot, q, v, a, config), repeats=1)


def scipy():
    """A design step as it is often written: cond(Y) of a Fourier series with differences for the gradient."""
    import pinocchio as pin
    from scipy.optimize import approx_fprime

    model = pin.buildModelFromUrdf(URDF)
    data = model.createData()
    n, order, samples = model.nv, 5, 100
    t = np.linspace(0, 10, samples, endpoint=False)
    w = 2 * np.pi * 0.1 * np.arange(1, order + 1)
    s, c = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    rng = np.random.default_rng(1)
    start = 0.1 * rng.standard_normal(2 * n * order)
    # Columns that motion can tell apart, found once.
    def rows(x):
        a, b = x.reshape(2, n, order)
        q, v, acc = (s / w) @ a.T - (c / w) @ b.T, c @ a.T + s @ b.T, (-s * w) @ a.T + (c * w) @ b.T
        return np.vstack([pin.computeJointTorqueRegressor(model, data, *k) for k in zip(q, v, acc)])

    from scipy.linalg import qr

    _, r, pivots = qr(rows(start), mode="economic", pivoting=True)
    kept = pivots[: np.sum(np.abs(np.diag(r)) > 1e-8 * abs(r[0, 0]))]
    cost = lambda x: np.log(np.linalg.cond(rows(x)[:, kept]))
    rounds("scipy_criterion_and_gradient", samples, lambda: (cost(start), approx_fprime(start, cost, 1e-7)), repeats=1)


def cvxpy():
    """The cone programme of physically consistent bodies in CVXPY's words, on a random problem of the size of seven links."""
    import cvxpy as cp

    links = 7
    rng = np.random.default_rng(1)
    # Bodies of a kilogram and a decimetre, seen through random rows with noise.
    body = np.array([1.0, 0.02, 0.01, 0.03, 0.01, 0, 0, 0.01, 0, 0.01])
    rows = rng.standard_normal((400, 10 * links)) * np.tile(body.clip(1e-3), links)
    torque = rows @ np.ones(10 * links) + 0.1 * rng.standard_normal(400)

    def solve():
        x = cp.Variable(10 * links)
        constraints = []
        for m, mx, my, mz, xx, xy, xz, yy, yz, zz in np.arange(10 * links).reshape(links, 10):
            h = (x[xx] + x[yy] + x[zz]) / 2
            constraints.append(cp.bmat([
                [h - x[xx], -x[xy], -x[xz], x[mx]],
                [-x[xy], h - x[yy], -x[yz], x[my]],
                [-x[xz], -x[yz], h - x[zz], x[mz]],
                [x[mx], x[my], x[mz], x[m]],
            ]) >> 1e-4 * np.eye(4))
        cp.Problem(cp.Minimize(cp.sum_squares(rows @ x - torque)), constraints).solve(solver=cp.CLARABEL)

    rounds("cvxpy_consistent_bodies", 1, solve, repeats=1)


for peer in (pinocchio, figaroh, scipy, cvxpy):
    try:
        peer()
    except Exception as error:  # what is not installed, or is not what it was
        print(f"skipped {peer.__name__}: {type(error).__name__}: {error}", flush=True)
