#!/usr/bin/env python3
"""Checks a designed excitation trajectory with a program of its own: numpy only, no code shared with dynident.

    python3 examples/check_design.py robot.json design.json

Recomputes, from the robot and the coefficients alone, the condition number of Y_b and every constraint: (14c) as corrected, (14d)-(14g)
with the paper's form, the true extremes over time in any case. Exit status 0 if all agree.

Y is built body by body: the wrench of each link for each of its ten parameters, brought to every joint before it by the geometric
Jacobian, all vectors in the base frame.
"""

import json
import sys

import numpy as np

PARAMETERS = ["M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ"]


def rotation(axis, angle):
    """Rotation matrices (..., 3, 3) about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    o, i = np.zeros_like(c), np.ones_like(c)
    rows = {
        "x": [[i, o, o], [o, c, -s], [o, s, c]],
        "y": [[c, o, s], [o, i, o], [-s, o, c]],
        "z": [[c, -s, o], [s, c, o], [o, o, i]],
    }[axis]
    return np.stack([np.stack(r, -1) for r in rows], -2)


def to_float(v):
    return np.array(float(v))


def fixed_part(joint):
    """Rotation and offset from the frame before to the joint's frame at q = 0."""
    if "mdh" in joint:
        m = joint["mdh"]
        rx, rz = rotation("x", to_float(m["alpha"])), rotation("z", to_float(m["theta"]))
        return rx @ rz, rx @ (np.array([m["d"], 0, 0]) + rz @ np.array([0, 0, m["r"]]))
    p = joint["placement"]
    if p.get("axis", [0, 0, 1]) != [0, 0, 1]:
        sys.exit("this program knows joints about z only")
    roll, pitch, yaw = (to_float(v) for v in p.get("rpy", [0, 0, 0]))
    return rotation("z", yaw) @ rotation("y", pitch) @ rotation("x", roll), np.array(p.get("xyz", [0, 0, 0]), float)


def states(design, times):
    """q, qd, qdd (samples, joints) of the series (12)."""
    a, b = (np.array(design["coefficients"][k]) for k in "ab")
    w = 2 * np.pi * design["fundamental_hz"] * np.arange(1, a.shape[1] + 1)
    s, c = np.sin(np.outer(times, w)), np.cos(np.outer(times, w))
    q = np.array(design["offset"]) + s @ (a / w).T - c @ (b / w).T
    return q, c @ a.T + s @ b.T, -s @ (a * w).T + c @ (b * w).T


def cross(a, b):
    return np.cross(a, b, axis=-1)


def regressor(robot, q, qd, qdd):
    """Y (samples, joints, 12 per link)."""
    samples, n = q.shape
    gravity = np.array(robot.get("gravity", [0, 0, -9.81]), float)
    rot, origin = np.broadcast_to(np.eye(3), (samples, 3, 3)), np.zeros((samples, 3))
    w, dw, acc = np.zeros((samples, 3)), np.zeros((samples, 3)), np.broadcast_to(-gravity, (samples, 3))
    axes, origins, kinds = [], [], []
    y = np.zeros((samples, n, 12 * n))
    for k, joint in enumerate(robot["joints"]):
        fixed, offset = fixed_part(joint)
        lever = rot @ offset
        rot = rot @ fixed
        z = rot[..., 2]
        revolute = joint["kind"] == "revolute"
        rate, change = qd[:, k, None] * z, qdd[:, k, None] * z
        if revolute:
            acc = acc + cross(dw, lever) + cross(w, cross(w, lever))
            dw = dw + change + cross(w, rate)
            w = w + rate
            rot = rot @ rotation("z", q[:, k])
        else:
            lever = lever + q[:, k, None] * z
            acc = acc + cross(dw, lever) + cross(w, cross(w, lever)) + 2 * cross(w, rate) + change
        origin = origin + lever
        axes.append(z), origins.append(origin), kinds.append(revolute)
        for p in range(10):
            force, moment = wrench(p, rot, w, dw, acc)
            for j in range(k + 1):
                arm = cross(origin - origins[j], force) + moment
                y[:, j, 12 * k + p] = np.sum(axes[j] * (arm if kinds[j] else force), -1)
        y[:, k, 12 * k + 10] = qd[:, k]
        y[:, k, 12 * k + 11] = np.sign(qd[:, k])
    return y


def wrench(p, rot, w, dw, acc):
    """Force, and moment about the link's origin, per unit of parameter p (Newton and Euler)."""
    if p == 0:
        return acc, np.zeros_like(acc)
    if p < 4:
        h = rot[..., p - 1]
        return cross(dw, h) + cross(w, cross(w, h)), cross(h, acc)
    i, j = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)][p - 4]
    unit = np.zeros((3, 3))
    unit[i, j] = unit[j, i] = 1
    inertia = rot @ unit @ np.swapaxes(rot, -1, -2)
    spin = (inertia @ w[..., None])[..., 0]
    return np.zeros_like(acc), (inertia @ dw[..., None])[..., 0] + cross(w, spin)


def names(robot):
    declared = robot.get("friction", ["viscous", "coulomb"])
    friction = [s for s, word in [("FV", "viscous"), ("FS", "coulomb")] if word in declared]
    n = len(robot["joints"])
    all_names = [f"{s}{k + 1}" for k in range(n) for s in PARAMETERS + ["FV", "FS"]]
    return all_names, [i for i, name in enumerate(all_names) if not name.startswith("F") or name[:2] in friction]


def base_columns(robot, columns):
    """The first columns of Y at random states that the columns before them cannot make."""
    rng = np.random.default_rng(1)
    n = len(robot["joints"])
    q, qd, qdd = rng.uniform(-3, 3, (200, n)), rng.uniform(-2, 2, (200, n)), rng.uniform(-5, 5, (200, n))
    w = regressor(robot, q, qd, qdd).reshape(-1, 12 * n)
    kept, basis = [], np.zeros((w.shape[0], 0))
    largest = np.linalg.norm(w, axis=0).max()
    for c in columns:
        rest = w[:, c]
        for _ in range(2):
            rest = rest - basis @ (basis.T @ rest)
        # Columns that are zero but for rounding, and those that others make but for rounding, go.
        own = np.linalg.norm(w[:, c])
        if own > 1e-8 * largest and np.linalg.norm(rest) > 1e-8 * own:
            kept.append(c)
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
    return kept


class Report:
    def __init__(self):
        self.good = True

    def check(self, what, good, detail):
        self.good &= bool(good)
        print(f"{'ok  ' if good else 'FAIL'} {what}: {detail}")


def check_paper_form(report, design, limits, start):
    a, b = (np.array(design["coefficients"][k]) for k in "ab")
    l = np.arange(1, a.shape[1] + 1)
    wf = 2 * np.pi * design["fundamental_hz"]
    amplitude = np.hypot(a, b)
    for j, limit in enumerate(limits):
        name = design["joints"][j]
        speed = limit.get("velocity")
        half = None
        if limit.get("position"):
            low, high = limit["position"]
            rest = 0.5 * (low + high) if start == "free" else design["offset"][j]
            half = min(rest - low, high - rest) - abs(design["offset"][j] - rest)
            used = np.sum(amplitude[j] / l) / (wf * half)
            report.check(f"(14d) {name}", used <= 1, f"{100 * used:.4f} % of the bound")
        if speed:
            used = np.sum(amplitude[j]) / speed
            report.check(f"(14e) {name}", used <= 1, f"{100 * used:.4f} % of the bound")
        if start == "zero":
            bound = np.minimum(l * wf * half / len(l) if half else np.inf, speed or np.inf)
            used = np.max(np.maximum(abs(a[j]), abs(b[j])) / bound)
            report.check(f"(14f,g) {name}", used <= 1, f"{100 * used:.4f} % of the bound")


def check_extremes(report, design, limits):
    times = np.linspace(0, 1 / design["fundamental_hz"], 20001)
    motion = states(design, times)
    for k, quantity in enumerate(["position", "velocity", "acceleration"]):
        for j, limit in enumerate(limits):
            bound = limit.get(quantity)
            if bound is None:
                continue
            low, high = bound if quantity == "position" else (-bound, bound)
            peak = motion[k][:, j].min(), motion[k][:, j].max()
            detail = f"{peak[0]:.6f} to {peak[1]:.6f}, allowed {low:.6f} to {high:.6f}"
            report.check(f"{quantity} {design['joints'][j]}", low <= peak[0] and peak[1] <= high, detail)


def main():
    robot, design = (json.load(open(path)) for path in sys.argv[1:3])
    report = Report()
    constraints = design["request"].get("constraints", {})
    form, start = constraints.get("form", "paper"), constraints.get("start", "zero")
    a, b = (np.array(design["coefficients"][k]) for k in "ab")
    l = np.arange(1, a.shape[1] + 1)
    # Sums of L terms of this size: rounding of a few units in the last place.
    rounding = 1e-14 * np.abs(np.concatenate([a, b])).sum() * len(l)
    sums = [("velocity at the start", a.sum(1)), ("acceleration at the start", b @ l)]
    if start == "zero":
        sums.append(("position at the start", b @ (1 / l)))
    for what, value in sums:
        report.check(f"(14c) {what}", np.abs(value).max() <= rounding, f"{np.abs(value).max():.1e}")
    limits = [joint.get("limits") or {} for joint in robot["joints"]]
    if form == "paper":
        check_paper_form(report, design, limits, start)
    check_extremes(report, design, limits)

    all_names, columns = names(robot)
    kept = base_columns(robot, columns)
    ours = [all_names[c] for c in kept]
    theirs = [name.replace("R", "") for name in design["base_parameters"]]
    report.check("base parameters", ours == theirs, f"{len(ours)} by elimination, {len(theirs)} in the design")
    times = np.arange(design["samples"]) / design["sample_rate_hz"]
    y_b = regressor(robot, *states(design, times)).reshape(-1, len(all_names))[:, kept]
    values = np.linalg.svd(y_b, compute_uv=False)
    cond = values[0] / values[-1]
    stated = design["condition_number"]
    # Singular values are known to 1e-16 of the largest, hence their ratio to cond times that, and the same again for Y itself.
    report.check("condition number", abs(cond - stated) <= 1e-9 * cond, f"{cond:.9f} here, {stated:.9f} in the design")
    print("all agree" if report.good else "DISAGREEMENT")
    sys.exit(0 if report.good else 1)


main()
