"""Makes ref_paper_chain.json: the paper's chain on an experiment of the paper's size, in NumPy, SciPy and Pinocchio.

    python3 ref_paper_chain.py > ref_paper_chain.json          (needs numpy, scipy, pin)

The log is made here as the test makes it, from formulas, so that it need not be stored: the finite Fourier series below, 16 periods of 10 s
at 1 kHz, torques of the paper's Table 3 (Pinocchio's recursive Newton-Euler and friction), and noise from splitmix64 of a counter. Then
mean of the periods, zero-phase Butterworth filters as second-order sections (order 20 at 2 Hz on positions, order 12 at 1.6 Hz on
torques) over the period continued round on both sides, central differences, the regressor, ordinary least squares, and (15).
"""

import json
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.signal import butter, sosfiltfilt

N, PERIODS, RATE, PERIOD = 7, 16, 1000.0, 10.0
HERE = Path(__file__).parent


def model():
    reference = json.loads((HERE / "ref_regressor.json").read_text())
    made, parent = pin.Model(), 0
    made.gravity.linear = np.array([0, 0, -9.81])
    for k in range(N):
        alpha = reference["alpha_sign"][k] * np.pi / 2
        turn = np.array([[1, 0, 0], [0, np.cos(alpha), -np.sin(alpha)], [0, np.sin(alpha), np.cos(alpha)]])
        place = pin.SE3(turn, turn @ np.array([0, 0, reference["r"][k]]))
        parent = made.addJoint(parent, pin.JointModelRZ(), place, f"A{k + 1}")
    return made, np.array(reference["table3_pi"]).reshape(N, 12)


# Pinocchio: m, h, Ixx, Ixy, Iyy, Ixz, Iyz, Izz. Here: M, MX, MY, MZ, XX, XY, XZ, YY, YZ, ZZ, FV, FS.
OURS = [0, 1, 2, 3, 4, 5, 7, 6, 8, 9]


def motion(t):
    omega = 2 * np.pi / PERIOD
    q, qd, qdd = (np.zeros((len(t), N)) for _ in range(3))
    for j in range(N):
        for l in range(1, 6):
            a = 0.1 * l * np.sin(0.4 + 1.3 * j + 2.1 * (l - 1))
            b = 0.1 * l * np.sin(1.7 + 1.3 * j + 2.1 * (l - 1))
            s, c = np.sin(omega * l * t), np.cos(omega * l * t)
            q[:, j] += (a * s - b * c) / (omega * l)
            qd[:, j] += a * c + b * s
            qdd[:, j] += omega * l * (b * c - a * s)
    return q, qd, qdd


def uniform(first, count):
    """Numbers in [-1, 1): splitmix64 of the counters from `first` on."""
    with np.errstate(over="ignore"):
        z = (np.arange(count, dtype=np.uint64) + np.uint64(first + 1)) * np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z ^= z >> np.uint64(31)
    return (z >> np.uint64(11)).astype(float) * 2.0**-52 - 1.0


def regressor(made, data, q, qd, qdd):
    y = np.zeros((len(q), N, N, 12))
    for s in range(len(q)):
        full = pin.computeJointTorqueRegressor(made, data, q[s], qd[s], qdd[s]).reshape(N, N, 10)
        y[s, :, :, :10] = full[:, :, OURS]
    for j in range(N):
        y[:, j, j, 10], y[:, j, j, 11] = qd[:, j], np.sign(qd[:, j])
    return y.reshape(len(q), N, 12 * N)


def zero_phase(order, cutoff, x):
    pad = 3 * len(x)
    sos = butter(order, cutoff, fs=RATE, output="sos")
    return sosfiltfilt(sos, np.tile(x, (7, 1)), axis=0, padlen=0)[pad : pad + len(x)]


def difference(x):
    return (np.roll(x, -1, axis=0) - np.roll(x, 1, axis=0)) * (RATE / 2)


def main():
    made, phi = model()
    data = made.createData()
    samples = int(PERIOD * RATE)
    q, qd, qdd = motion(np.arange(samples) / RATE)
    tau = regressor(made, data, q, qd, qdd) @ phi.ravel()
    amplitude = np.array([1.2, 1.4, 0.5, 0.6, 0.3, 0.7, 0.25])
    rows = PERIODS * samples
    noise = lambda column: uniform(column * rows, rows).reshape(PERIODS, samples)
    mean = lambda x, column, size: x + size * noise(column).mean(axis=0)
    q = np.stack([mean(q[:, j], j, 2e-5) for j in range(N)], axis=1)
    tau = np.stack([mean(tau[:, j], N + j, amplitude[j]) for j in range(N)], axis=1)
    q, tau = zero_phase(20, 2.0, q), zero_phase(12, 1.6, tau)
    qd = difference(q)
    qdd = difference(qd)
    columns = json.loads((HERE / "ref_base.json").read_text())["base_cols"]
    w = regressor(made, data, q, qd, qdd)[:, :, columns].reshape(-1, len(columns))
    value, _, rank, singular = np.linalg.lstsq(w, tau.ravel(), rcond=None)
    error = tau - (w @ value).reshape(tau.shape)
    variance = (error**2).sum() / (w.shape[0] - rank)
    deviation = np.sqrt(variance * np.diag(np.linalg.inv(w.T @ w)))
    print(json.dumps({
        "versions": {"numpy": np.__version__, "pinocchio": pin.__version__, "scipy": __import__("scipy").__version__},
        "rank": int(rank), "condition_number": float(singular[0] / singular[-1]), "value": value.tolist(),
        "std_dev": deviation.tolist(), "rms": np.sqrt((error**2).mean(axis=0)).tolist(),
        "torque_rms": np.sqrt((tau**2).mean(axis=0)).tolist(),
    }, indent=1))


main()
