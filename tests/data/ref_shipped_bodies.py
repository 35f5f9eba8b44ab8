"""Torques of shipped arms whose bodies were published in other frames than ours, by Pinocchio from the published numbers: `python ref_shipped_bodies.py > ref_shipped_bodies.json`.

LWR 4+: FloBaRoID (github.com/kjyv, commit 9c068044), model/kuka_lwr4.urdf; the moments of its link 7 are those of a cylinder of 40 mm radius and height instead of 0.05 kg m2.
TX40: figaroh-examples (github.com/thanhndv212, commit c0b5c7f0), examples/staubli_TX40: tx40_mdh_modified.urdf (its zero has the arm stretched out: q2 and q3 differ by a quarter turn from
the maker's; moments of link 6, 0.000 there, are 0.0001) and TX40_config.yaml (friction).
"""
import json
from math import pi

import numpy as np
import pinocchio as pin

RAW, DEEP = (0.01845, 0.00405, 0.01602, 0, 0, 0), (0, 0, 0)
ARMS = {
    "lwr4": {
        # Origin, roll-pitch-yaw and axis of each joint; mass, centre, xx, yy, zz, xy, xz, yz, and yaw of the moments' frame.
        "joints": [((0, 0, z), DEEP, a) for z, a in [(0.11, (0, 0, 1)), (0.2005, (0, -1, 0)), (0.2, (0, 0, 1)), (0.2, (0, 1, 0)), (0.2, (0, 0, 1)), (0.19, (0, -1, 0)), (0.078, (0, 0, 1))]],
        "bodies": [
            (2.7, (0, -0.06, 0.13), RAW, 0), (2.7, (0, 0.06, 0.07), RAW, 0), (2.7, (0, 0.06, 0.13), RAW, 0), (2.7, (0, -0.06, 0.07), RAW, 0),
            (1.7, (0, 0, 0.124), (0.0107530666667, 0.00255, 0.00922306666667, 0, 0, 0), 0), (1.6, (0, 0, 0.0625), (0.00416666666667,) * 3 + (0, 0, 0), 0),
            (0.3, (0, 0, 0), (0.00016, 0.00016, 0.00024, 0, 0, 0), 0),
        ],
        "zero": [0] * 7, "viscous": [0] * 7, "coulomb": [0] * 7,
    },
    "tx40": {
        "joints": [((0, 0, 0.32), DEEP, (0, 0, 1)), ((0, 0, 0), (-pi / 2, 0, 0), (0, 0, 1)), ((0.225, 0, 0.035), DEEP, (0, 0, 1)), ((0, -0.225, 0), (pi / 2, 0, 0), (0, 0, 1)),
                   ((0, 0, 0), (-pi / 2, 0, 0), (0, 0, 1)), ((0, 0, 0), (pi / 2, pi, 0), (0, 0, 1))],
        "bodies": [
            (10.5, (0, 0.02, -0.043), (0.055, 0.047, 0.035, 0, 0, 0.003), 0), (3.6, (0.109, -0.002, 0.134), (0.009, 0.038, 0.040, 0, 0.002, 0), -pi / 2),
            (4.07, (0.008, 0.006, 0.041), (0.012, 0.012, 0.004, 0, 0.001, -0.001), -pi / 2), (3.62, (-0.004, 0.002, -0.107), (0.013, 0.014, 0.004, 0, 0, 0.001), pi / 2),
            (1.02, (-0.004, -0.003, -0.001), (0.001, 0.001, 0.001, 0, 0, 0), -pi / 2), (0.2, (0, 0, 0.042), (0.0001, 0.0001, 0.0001, 0, 0, 0), -pi / 2),
        ],
        "zero": [0, -pi / 2, pi / 2, 0, 0, 0], "viscous": [8.05, 5.53, 1.97, 1.11, 1.86, 0.65], "coulomb": [7.14, 8.26, 6.34, 2.48, 3.03, 0.282],
    },
}


def moments(values, yaw):
    xx, yy, zz, xy, xz, yz = values
    turn = pin.rpy.rpyToMatrix(0.0, 0.0, yaw)
    return turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T


def states(arm):
    model, parent = pin.Model(), 0
    for (xyz, rpy, axis), (mass, centre, values, yaw) in zip(arm["joints"], arm["bodies"]):
        place = pin.SE3(pin.rpy.rpyToMatrix(*map(float, rpy)), np.array(xyz, float))
        parent = model.addJoint(parent, pin.JointModelRevoluteUnaligned(np.array(axis, float)), place, f"j{parent}")
        model.appendBodyToJoint(parent, pin.Inertia(mass, np.array(centre, float), moments(values, yaw)), pin.SE3.Identity())
    data, rng = model.createData(), np.random.default_rng(5)
    for _ in range(5):
        q, v, a = (rng.uniform(-s, s, model.nv) for s in (2, 2, 4))
        torque = pin.rnea(model, data, q + np.array(arm["zero"]), v, a) + np.array(arm["viscous"]) * v + np.array(arm["coulomb"]) * np.sign(v)
        yield {"q": q.tolist(), "qd": v.tolist(), "qdd": a.tolist(), "torque": torque.tolist()}


if __name__ == "__main__":
    print(json.dumps({"pinocchio": pin.__version__, "arms": {name: list(states(arm)) for name, arm in ARMS.items()}}, indent=0))
