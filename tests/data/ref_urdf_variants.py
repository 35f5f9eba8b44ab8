"""Forty URDF files as people have them, with number of base parameters and torques by Pinocchio: `python ref_urdf_variants.py > ref_urdf_variants.json`.

Every arm is written twice: exactly, which Pinocchio reads, and with one or more of what files in the wild have (rounded quarter turns, mimic grippers,
branches, undeclared prefixes, placeholders of limits). Joints off the chain are locked at zero in Pinocchio.
"""
import json
import math
import random

import numpy as np
import pinocchio as pin

STATES = 3


def rounded(angle, rng):
    digits = rng.choice([2, 3, 4, 5, 6])
    return rng.choice([f"{angle:.{digits}f}", str(math.trunc(angle * 10**digits) / 10**digits)])


def inertial(rng):
    m = rng.uniform(0.5, 5)
    d = sorted(rng.uniform(0.01, 0.02) for _ in range(3))
    c = [f"{rng.uniform(-0.2, 0.2):.4f}" for _ in range(3)]
    return (f'<inertial><origin xyz="{" ".join(c)}" rpy="0.3 -0.2 0.5"/><mass value="{m:.4f}"/>'
            f'<inertia ixx="{d[0]:.6f}" iyy="{d[1]:.6f}" izz="{d[2]:.6f}" ixy="0" ixz="0" iyz="0"/></inertial>')


def arm(index):
    """(exact, as found, chain, tip)"""
    rng = random.Random(index)
    n = rng.randint(2, 7)
    traits = rng.sample(["rounded", "gripper", "branch", "prefix", "limits", "comment", "fixed", "world"], rng.randint(1, 4))
    parts, chain, tip = [], [], None
    parts.append(("<link name=\"base\"/>",) * 2)
    before = "base"
    if "world" in traits:
        parts.append(('<link name="world"/><joint name="stand" type="fixed"><parent link="world"/><child link="base"/>'
                      '<origin xyz="0 0 0.3"/></joint>',) * 2)
    for k in range(n):
        body = inertial(rng)
        kind = "prismatic" if rng.random() < 0.2 else "revolute"
        quarters = [rng.choice([0, 1, -1, 2]) for _ in range(3)] if rng.random() < 0.8 else None
        if quarters:
            exact = [repr(q * math.pi / 2) for q in quarters]
            found = [rounded(q * math.pi / 2, rng) if "rounded" in traits and q else e for q, e in zip(quarters, exact)]
        else:
            exact = found = [f"{rng.uniform(-1, 1):.4f}" for _ in range(3)]
        xyz = " ".join(rng.choice(["0", f"{rng.uniform(-0.5, 0.5):.4f}"]) for _ in range(3))
        axis = rng.choice(["0 0 1", "0 1 0", "1 0 0", "0 0 -1"])
        limit = 'lower="-2" upper="2" velocity="2" effort="50"'
        odd = limit
        if "limits" in traits and kind == "revolute":
            odd = rng.choice(['lower="-1e16" upper="1e16" velocity="2" effort="50"', 'lower="0" upper="0" velocity="1000" effort="0"',
                              'lower="-10000" upper="10000" velocity="2" effort="1e9"'])
        if "prefix" in traits:
            odd += ' drake:acceleration="15"'
        text = ('<link name="l{k}">{body}</link><joint name="j{k}" type="{kind}"><parent link="{before}"/><child link="l{k}"/>'
                '<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/><limit {limit}/></joint>')
        put = lambda rpy, limit: text.format(k=k, body=body, kind=kind, before=before, xyz=xyz, rpy=" ".join(rpy), axis=axis, limit=limit)
        parts.append((put(exact, limit), put(found, odd)))
        chain.append(f"j{k}")
        before = f"l{k}"
        if "fixed" in traits and rng.random() < 0.5:
            parts.append((f'<link name="m{k}">{inertial(rng)}</link><joint name="b{k}" type="fixed"><parent link="l{k}"/><child link="m{k}"/>'
                          f'<origin xyz="0.05 0 0.02" rpy="0.4 0 0"/></joint>',) * 2)
    if "gripper" in traits:
        finger = lambda name, sign, mimic: (
            f'<link name="{name}">{inertial(rng)}</link><joint name="{name}_joint" type="prismatic"><parent link="{before}"/><child link="{name}"/>'
            f'<origin xyz="0 {sign}0.02 0.1"/><axis xyz="0 {sign}1 0"/>{mimic}<limit lower="0" upper="0.04" velocity="1" effort="9"/></joint>')
        left, right = finger("left", "", ""), finger("right", "-", '<mimic joint="left_joint"/>')
        parts.append((left + right.replace('<mimic joint="left_joint"/>', ""), left + right))
    if "branch" in traits:
        parts.append((f'<link name="camera">{inertial(rng)}</link><joint name="pan" type="revolute"><parent link="l0"/><child link="camera"/>'
                      f'<origin xyz="0 0.1 0.1" rpy="0 0.3 0"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="9"/></joint>',) * 2)
        tip = before
    exact = '<robot name="variant">' + "\n".join(p[0] for p in parts) + "</robot>"
    found = '<robot name="variant">' + "\n".join(p[1] for p in parts) + "</robot>"
    if "comment" in traits:
        found = "<!-- exported by hand -->\n<?xml version=\"1.0\"?>\n" + found
    return exact, found, chain, tip, sorted(traits)


def reference(exact, chain):
    full = pin.buildModelFromXML(exact)
    locked = [j for j in range(1, full.njoints) if full.names[j] not in chain]
    model = pin.buildReducedModel(full, locked, pin.neutral(full))
    assert list(model.names)[1:] == chain, (list(model.names), chain)
    data, rng = model.createData(), np.random.default_rng(1)
    state = lambda: [rng.uniform(-s, s, model.nv) for s in (2, 2, 4)]
    rows = np.vstack([pin.computeJointTorqueRegressor(model, data, *state()) for _ in range(200)])
    sizes = np.linalg.norm(rows, axis=0)
    # Columns of rounding errors have no direction.
    rows = rows[:, sizes > 1e-10 * sizes.max()] / sizes[sizes > 1e-10 * sizes.max()]
    s = np.linalg.svd(rows, compute_uv=False)
    rank = int((s > 1e-9 * s[0]).sum())
    assert rank == len(s) or s[rank] < 1e-12 * s[0], s[rank - 2:rank + 2] / s[0]
    states = []
    for _ in range(STATES):
        q, v, a = state()
        states.append({"q": q.tolist(), "qd": v.tolist(), "qdd": a.tolist(), "torque": pin.rnea(model, data, q, v, a).tolist()})
    return rank, states


variants = []
for index in range(40):
    exact, found, chain, tip, traits = arm(index)
    rank, states = reference(exact, chain)
    variants.append({"traits": traits, "urdf": found, "tip": tip, "joints": chain, "inertial_base_parameters": rank, "states": states})
print(json.dumps({"pinocchio": pin.__version__, "variants": variants}, indent=0))
