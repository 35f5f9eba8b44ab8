"""The paper's chain in pandas, SciPy and Pinocchio: CSV -> mean of 16 periods -> zero-phase Butterworth -> central differences ->
regressor -> base columns by rank-revealing QR -> least squares. Prints one JSON object: seconds, rms per joint, peak_mb.

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
from scipy.signal import butter, sosfiltfilt

PERIODS, RATE = 16, 1000.0


def zero_phase(order, cutoff, x, pad):
    """Over one period of something that repeats: continued round on both sides."""
    sos = butter(order, cutoff, fs=RATE, output="sos")
    longer = np.take(x, range(-pad, len(x) + pad), axis=0, mode="wrap")
    return sosfiltfilt(sos, longer, axis=0, padlen=0)[pad:-pad]


def difference(x):
    return (np.roll(x, -1, axis=0) - np.roll(x, 1, axis=0)) * (RATE / 2)


def main():
    begun = time.perf_counter()
    model = pin.buildModelFromUrdf(sys.argv[1])
    data = model.createData()
    table = pd.read_csv(sys.argv[2])
    n = model.nv
    mean = lambda stem: table[[f"{stem}{k}" for k in range(1, n + 1)]].to_numpy().reshape(PERIODS, -1, n).mean(axis=0)
    q, tau = zero_phase(20, 2.0, mean("q"), 5000), zero_phase(12, 1.6, mean("tau"), 5000)
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
    w = w[:, base]
    solution, *_ = np.linalg.lstsq(w, tau.reshape(-1), rcond=None)
    residual = tau - (w @ solution).reshape(rows, n)
    seconds = time.perf_counter() - begun
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({"seconds": seconds, "rms": list(np.sqrt((residual**2).mean(axis=0))), "peak_mb": peak, "base": len(base)}))


main()
