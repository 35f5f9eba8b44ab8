"""Logs of arms whose friction MuJoCo regularises (`frictionloss`): `python friction.py ARM SHARPNESS SEED > log.csv`.

The torque is that of inverse dynamics along a periodic motion, with white noise on it and on the positions. `xml` has the robot. MuJoCo's friction is a soft constraint: with
b = 2 / (dmax timeconst) and R = (1 - d) / d / M it is F clamp((qd + qdd / b) b / (R F), -1, 1) (Todorov 2014).
"""
import sys

import mujoco
import numpy as np

# Axis, offset of the next joint, mass, centre, friction loss, damping of every joint.
ARMS = {
    "three": [
        ("0 0 1", "0 0 0.2", 3.0, "0.02 0.01 0.1", 1.2, 0.8),
        ("0 1 0", "0.35 0 0", 2.5, "0.17 0.02 0.01", 1.0, 0.7),
        ("0 1 0", "0.3 0 0", 1.2, "0.12 -0.01 0.02", 0.5, 0.3),
    ],
    "four": [
        ("0 0 1", "0 0 0.3", 4.0, "0.03 0.02 0.12", 2.0, 1.1),
        ("0 1 0", "0 0 0.4", 3.0, "0.02 0.01 0.2", 1.5, 0.9),
        ("0 1 0", "0.05 0 0.1", 1.5, "0.04 -0.02 0.05", 0.8, 0.5),
        ("0 0 1", "0 0 0.2", 0.8, "0.03 0.01 0.1", 0.4, 0.2),
    ],
    "six": [
        ("0 0 1", "0 0 0.15", 5.0, "0.02 0.02 0.08", 2.0, 1.2),
        ("0 1 0", "0 0 0.45", 4.0, "0.01 0.03 0.22", 2.0, 1.2),
        ("0 1 0", "0.4 0 0", 2.5, "0.2 -0.02 0.01", 1.2, 0.8),
        ("1 0 0", "0.1 0 0", 1.2, "0.05 0.02 0.01", 0.6, 0.4),
        ("0 1 0", "0.1 0 0", 0.8, "0.05 0.01 0.02", 0.5, 0.3),
        ("1 0 0", "0.05 0 0", 0.5, "0.03 0.02 0.01", 0.3, 0.2),
    ],
}
# solreffriction, solimpfriction: harder than MuJoCo's own, its own, and softer.
SHARPNESS = {
    "sharp": ("0.02 1", "0.99 0.99 0.001"),
    "plain": ("0.02 1", "0.9 0.95 0.001"),
    "soft": ("0.04 1", "0.9 0.9 0.001"),
}


def xml(arm, sharpness):
    ref, imp = SHARPNESS[sharpness]
    text, end = "", ""
    at = "0 0 0"
    for i, (axis, nxt, mass, centre, loss, damping) in enumerate(ARMS[arm]):
        text += f'<body pos="{at}"><joint name="J{i + 1}" axis="{axis}" damping="{damping}" frictionloss="{loss}" solreffriction="{ref}" solimpfriction="{imp}"/>'
        size = 0.004 * mass
        text += f'<inertial pos="{centre}" mass="{mass}" diaginertia="{size} {1.2 * size} {0.8 * size}"/>'
        at, end = nxt, end + "</body>"
    return f'<mujoco model="{arm}"><worldbody>{text}{end}</worldbody></mujoco>'


def excitation(rng, joints, travel=1.2, speed=1.2, fundamental=0.1, order=5):
    """Random Fourier series, every joint scaled to its travel and speed."""
    l = np.arange(1, order + 1)
    w = 2 * np.pi * fundamental * l
    a, b = rng.uniform(-1, 1, (2, joints, order))

    def state(t, a, b):
        s, c = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
        q = (s / w) @ a.T - (c / w) @ b.T
        return q, c @ a.T + s @ b.T, -(s * w) @ a.T + (c * w) @ b.T

    t = np.linspace(0, 1 / fundamental, 2000)
    q, v, _ = state(t, a, b)
    scale = np.minimum(speed / abs(v).max(0), travel / abs(q).max(0))
    return lambda t: state(t, a * scale[:, None], b * scale[:, None])


def log(arm, sharpness, seed, periods=3, rate=100.0, torque_noise=0.02, position_noise=2.5e-5):
    model = mujoco.MjModel.from_xml_string(xml(arm, sharpness))
    data = mujoco.MjData(model)
    rng = np.random.default_rng(seed)
    motion = excitation(rng, model.nv)
    time = np.arange(int(round(periods * 10 * rate))) / rate
    q, v, a = motion(time)
    tau = np.empty_like(q)
    for s in range(len(time)):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[s], v[s], a[s]
        mujoco.mj_inverse(model, data)
        tau[s] = data.qfrc_inverse
    level = torque_noise * np.array([joint[4] for joint in ARMS[arm]])
    tau += rng.normal(size=tau.shape) * level
    q = q + rng.normal(size=q.shape) * position_noise
    return time, q, tau


if __name__ == "__main__":
    arm, sharpness, seed = sys.argv[1], sys.argv[2], int(sys.argv[3])
    time, q, tau = log(arm, sharpness, seed)
    n = q.shape[1]
    print(",".join(["t"] + [f"q{j + 1}" for j in range(n)] + [f"tau{j + 1}" for j in range(n)]))
    for t, x, y in zip(time, q, tau):
        print(",".join([f"{t:.4f}"] + [f"{v:.6f}" for v in x] + [f"{v:.4f}" for v in y]))
