"""The paper's chain in pandas, SciPy and Pinocchio: CSV -> mean of 16 periods -> zero-phase Butterworth -> central differences ->
regressor -> base columns by rank-revealing QR -> least squares -> physically consistent parameters. Prints one JSON object: seconds as far
as the base parameters, full_seconds with the physical ones, ratio of their fit to that of the base parameters, rms per joint, peak_mb.

The physical parameters are those of a positive definite pseudo-inertia of every link, J = L L' with a lower triangular L of positive diagonal
(log-Cholesky, Rucker and Wensing 2022), which makes the problem one without constraints; SciPy's L-BFGS with exact gradients solves it.

    python3 identify_reference.py ROBOT.urdf LOG.csv
"""

import json
import resource
import sys
import time

import numpy as np
import pandas as pd
import pinocchio as pin
from scipy.linalg import qr
from scipy.optimize import minimize
from scipy.signal import butter, sosfiltfilt

PERIODS, RATE = 16, 1000.0


def zero_phase(order, cutoff, x, pad):
    """Over one period of something that repeats: continued round on both sides."""
    sos = butter(order, cutoff, fs=RATE, output="sos")
    longer = np.take(x, range(-pad, len(x) + pad), axis=0, mode="wrap")
    return sosfiltfilt(sos, longer, axis=0, padlen=0)[pad:-pad]


def difference(x):
    return (np.roll(x, -1, axis=0) - np.roll(x, 1, axis=0)) * (RATE / 2)


# Entries of the pseudo-inertia that Pinocchio's m, h, Ixx, Ixy, Iyy, Ixz, Iyz, Izz make: J = sum of parameter times basis.
def basis():
    unit = np.zeros((10, 4, 4))
    unit[0, 3, 3] = 1
    for axis in range(3):
        unit[1 + axis, axis, 3] = unit[1 + axis, 3, axis] = 1
    for k, (r, c) in {4: (0, 0), 5: (0, 1), 6: (1, 1), 7: (0, 2), 8: (1, 2), 9: (2, 2)}.items():
        tensor = np.zeros((3, 3))
        tensor[r, c] = tensor[c, r] = 1
        unit[k, :3, :3] = 0.5 * np.trace(tensor) * np.eye(3) - tensor
    return unit


def physical(gram, moment, square, n):
    """Least squares over positive definite pseudo-inertias and friction that is not negative."""
    to_parameters = np.linalg.pinv(basis().reshape(10, 16).T)
    rows, columns = np.tril_indices(4)
    diagonal = rows == columns
    scale = np.trace(gram) / len(moment)

    def unpack(x):
        factors = np.zeros((n, 4, 4))
        entries = x[: 10 * n].reshape(n, 10).copy()
        entries[:, diagonal] = np.exp(entries[:, diagonal])
        factors[:, rows, columns] = entries
        inertial = (factors @ factors.transpose(0, 2, 1)).reshape(n, 16) @ to_parameters.T
        return factors, np.concatenate([inertial.ravel(), x[10 * n :] ** 2])

    def cost(x):
        factors, phi = unpack(x)
        along = gram @ phi - moment
        by_phi = 2 * along / scale
        by_pseudo = (by_phi[: 10 * n].reshape(n, 10) @ to_parameters).reshape(n, 4, 4)
        by_factor = ((by_pseudo + by_pseudo.transpose(0, 2, 1)) @ factors)[:, rows, columns]
        by_factor[:, diagonal] *= factors[:, rows, columns][:, diagonal]
        gradient = np.concatenate([by_factor.ravel(), 2 * x[10 * n :] * by_phi[10 * n :]])
        return (phi @ along - phi @ moment + square) / scale, gradient

    start = np.zeros((n, 10))
    start[:, diagonal] = np.log([0.1, 0.1, 0.1, 1.5])
    x = np.concatenate([start.ravel(), np.full(2 * n, 0.3)])
    options = {"maxiter": 20000, "maxfun": 40000, "ftol": 1e-12, "gtol": 1e-10}
    found = minimize(cost, x, jac=True, method="L-BFGS-B", options=options)
    return found.fun * scale


def main():
    begun = time.perf_counter()
    model = pin.buildModelFromUrdf(sys.argv[1])
    data = model.createData()
    table = pd.read_csv(sys.argv[2])
    n = model.nv
    mean = lambda stem: table[[f"{stem}{k}" for k in range(1, n + 1)]].to_numpy().reshape(PERIODS, -1, n).mean(axis=0)
    q, tau = zero_phase(20, 2.0, mean("q"), 20000), zero_phase(12, 1.6, mean("tau"), 20000)
    qd = difference(q)
    qdd = difference(qd)
    rows = len(q)
    inertial = np.stack([pin.computeJointTorqueRegressor(model, data, q[s], qd[s], qdd[s]) for s in range(rows)])
    friction = np.zeros((rows, n, 2 * n))
    for j in range(n):
        friction[:, j, 2 * j] = qd[:, j]
        friction[:, j, 2 * j + 1] = np.sign(qd[:, j])
    w = np.concatenate([inertial, friction], axis=2).reshape(rows * n, -1)
    # The base columns are those of a regressor at random states; on the path itself noise would blur the rank.
    rng = np.random.default_rng(1)
    states = [pin.computeJointTorqueRegressor(model, data, *rng.uniform(-1, 1, (3, n))) for _ in range(100)]
    _, r, order = qr(np.concatenate(states), mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(r))
    rank = int(np.sum(diagonal > 1e-9 * diagonal[0]))
    base = np.concatenate([np.sort(order[:rank]), np.arange(10 * n, 12 * n)])
    wb = w[:, base]
    solution, *_ = np.linalg.lstsq(wb, tau.reshape(-1), rcond=None)
    residual = tau - (wb @ solution).reshape(rows, n)
    seconds = time.perf_counter() - begun
    cost = physical(w.T @ w, w.T @ tau.reshape(-1), float((tau**2).sum()), n)
    ratio = float(np.sqrt(cost / (residual**2).sum()))
    full = time.perf_counter() - begun
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    rms = list(np.sqrt((residual**2).mean(axis=0)))
    print(json.dumps({"seconds": seconds, "full_seconds": full, "ratio": ratio, "rms": rms, "peak_mb": peak, "base": len(base)}))


main()
