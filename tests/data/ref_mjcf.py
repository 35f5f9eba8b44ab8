"""Torques of tests/data/ref_mjcf.xml at random states by MuJoCo: `python ref_mjcf.py > ref_mjcf.json`."""
import json
import pathlib

import mujoco
import numpy as np

model = mujoco.MjModel.from_xml_path(str(pathlib.Path(__file__).with_name("ref_mjcf.xml")))
model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
data = mujoco.MjData(model)
rng = np.random.default_rng(17)
states = []
for _ in range(20):
    data.qpos[:], data.qvel[:], data.qacc[:] = (rng.uniform(-s, s, model.nv) for s in (1.5, 2, 5))
    mujoco.mj_inverse(model, data)
    states.append({"q": data.qpos.tolist(), "qd": data.qvel.tolist(), "qdd": data.qacc.tolist(), "torque": data.qfrc_inverse.tolist()})
names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, j) for j in range(model.njnt)]
print(json.dumps({"mujoco": mujoco.__version__, "joints": names, "states": states}, indent=1))
