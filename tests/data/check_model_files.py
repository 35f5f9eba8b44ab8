"""Holds model files against the torques of this program: python check_model_files.py FOLDER

Every sub-folder has `states.json` (joints, gravity, q, qd, qdd, and the expected torque of each format) and the files. URDF is loaded by Pinocchio, MJCF by MuJoCo, SDF by the
reader below (its frames are those of SDF 1.7), C compiled by gcc, Python imported. The largest differences come out as JSON.
"""
import ctypes
import importlib.util
import json
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin

FRICTION = {"urdf", "sdf", "patched_urdf"}


def pinocchio_torques(model, damping, friction, spring, states):
    data = model.createData()
    out = []
    for q, v, a in states:
        full = np.zeros(model.nq)
        for j, value in zip(list(model.joints)[1:], q):
            full[j.idx_q:j.idx_q + j.nq] = [value] if j.nq == 1 else [np.cos(value), np.sin(value)]
        out.append(pin.rnea(model, data, full, v, a) + damping * v + friction * np.sign(v) + spring(q))
    return np.array(out)


def urdf(path, about, states):
    model = pin.buildModelFromUrdf(str(path))
    model.gravity.linear = np.array([0, 0, -np.linalg.norm(about["gravity"])])
    assert [n for n in model.names][1:] == about["joints"], list(model.names)
    dynamics = {j.get("name"): j.find("dynamics") for j in ET.parse(path).getroot().iter("joint")}
    damping, friction = (np.array([float(dynamics[n].get(k)) for n in about["joints"]]) for k in ("damping", "friction"))
    return pinocchio_torques(model, damping, friction, lambda q: 0.0, states)


def pose(element):
    v = [float(x) for x in element.text.split()]
    return pin.SE3(pin.rpy.rpyToMatrix(*v[3:]), np.array(v[:3]))


def sdf(path, about, states):
    root = ET.parse(path).getroot().find("model")
    links = {link.get("name"): link for link in root.iter("link")}
    model, at, base = pin.Model(), {}, None
    values = []
    for joint in root.iter("joint"):
        parent, child = joint.findtext("parent"), joint.findtext("child")
        if joint.get("type") == "fixed":
            assert parent == "world"
            base, at[child] = pose(links[child].find("pose")), 0
            continue
        where = joint.find("pose")
        assert where.get("relative_to") == parent and links[child].find("pose").get("relative_to") == joint.get("name")
        place = (base if at[parent] == 0 else pin.SE3.Identity()) * pose(where)
        axis = np.array([float(x) for x in joint.findtext("axis/xyz").split()])
        kind = pin.JointModelPrismaticUnaligned if joint.get("type") == "prismatic" else pin.JointModelRevoluteUnaligned
        at[child] = model.addJoint(at[parent], kind(axis / np.linalg.norm(axis)), place, joint.get("name"))
        body = links[child].find("inertial")
        i = {k: float(body.findtext(f"inertia/{k}")) for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")}
        inertia = np.array([[i["ixx"], i["ixy"], i["ixz"]], [i["ixy"], i["iyy"], i["iyz"]], [i["ixz"], i["iyz"], i["izz"]]])
        centre = pose(body.find("pose"))
        model.appendBodyToJoint(at[child], pin.Inertia(float(body.findtext("mass")), centre.translation, inertia), pin.SE3.Identity())
        values.append([float(joint.findtext(f"axis/dynamics/{k}") or 0) for k in ("damping", "friction", "spring_stiffness", "spring_reference")])
    damping, friction, stiffness, rest = np.array(values).T
    model.gravity.linear = np.array([0, 0, -np.linalg.norm(about["gravity"])])
    return pinocchio_torques(model, damping, friction, lambda q: stiffness * (q - rest), states)


def mjcf(path, about, states):
    model = mujoco.MjModel.from_xml_path(str(path))
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, j) for j in range(model.njnt)]
    assert names == about["joints"], names
    # Limits of positions are constraints of their own.
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    data = mujoco.MjData(model)
    out = []
    for q, v, a in states:
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_inverse(model, data)
        controls = (data.qfrc_inverse - model.actuator_biasprm[:, 0]) / model.actuator_gainprm[:, 0]
        out.append(controls)
        # The actuators are what is said of them: with these controls they put the inverse dynamics' torques on the joints.
        data.ctrl[:] = controls
        if not model.actuator_ctrllimited.any():
            mujoco.mj_fwdPosition(model, data), mujoco.mj_fwdVelocity(model, data), mujoco.mj_fwdActuation(model, data)
            assert np.abs(data.qfrc_actuator - data.qfrc_inverse).max() < 1e-9
    return np.array(out)


def loaded_python(path):
    spec = importlib.util.spec_from_file_location("model", path)
    model = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(model)
    return model


def python(path, about, states):
    model = loaded_python(path)
    assert model.JOINTS == about["joints"]
    return functions(model.inverse_dynamics, model.gravity, model.mass_matrix, about, states)


INTERVAL = 2e-3


def python_predict(path, about, states):
    return np.array(loaded_python(path).predict(*zip(*states), INTERVAL))


def python_step(path, about, states):
    stepper = loaded_python(path).Stepper(INTERVAL)
    return np.array([stepper.step(*s) for s in states])


def c_predict(path, about, states):
    loaded, n = loaded_c(path), len(about["joints"])
    tau = np.empty((len(states), n))
    q, qd, qdd = (np.ascontiguousarray(v) for v in zip(*states))
    pointers = [v.ctypes.data_as(ctypes.c_void_p) for v in (q, qd, qdd, tau)]
    predict = getattr(loaded, f"{about['prefix']}_predict")
    assert predict(ctypes.c_long(len(states)), ctypes.c_double(INTERVAL), *pointers) == 0
    assert predict(ctypes.c_long(0), ctypes.c_double(INTERVAL), *pointers) == 1
    assert predict(ctypes.c_long(len(states)), ctypes.c_double(float("nan")), *pointers) == 1
    return tau


def c_step(path, about, states):
    loaded, prefix, n = loaded_c(path), about["prefix"], len(about["joints"])
    size = getattr(loaded, f"{prefix}_state_size")
    size.restype = ctypes.c_size_t
    state = ctypes.create_string_buffer(size())
    assert getattr(loaded, f"{prefix}_reset")(state, ctypes.c_double(1e-4)) == 1, "faster than the state has room for"
    assert getattr(loaded, f"{prefix}_reset")(state, ctypes.c_double(INTERVAL)) == 0
    out, array = [], lambda values: (ctypes.c_double * n)(*values)
    for s in states:
        tau = array([0.0] * n)
        getattr(loaded, f"{prefix}_step")(state, *(array(v) for v in s), tau)
        out.append(list(tau))
    return np.array(out)


def loaded_c(path):
    library = path.with_suffix(".so")
    subprocess.run(["gcc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-shared", "-fPIC", "-o", library, path, "-lm"], check=True)
    return ctypes.CDLL(str(library))


def c(path, about, states):
    loaded = loaded_c(path)
    n, prefix = len(about["joints"]), about["prefix"]
    array = lambda values: (ctypes.c_double * len(values))(*values)

    def call(name, size, *values):
        out = array([0.0] * size)
        getattr(loaded, f"{prefix}_{name}")(*(array(v) for v in values), out)
        return np.array(out)

    return functions(
        lambda *s: call("inverse_dynamics", n, *s), lambda q: call("gravity", n, q), lambda q: call("mass_matrix", n * n, q).reshape(n, n), about, states
    )


def functions(inverse_dynamics, gravity, mass_matrix, about, states):
    """Torques; gravity torques and mass matrix are held against them, where effects are linear in the accelerations."""
    n = len(about["joints"])
    for q, _, a in states[:3]:
        still = np.zeros(n)
        rest = np.array(inverse_dynamics(q, still, still))
        assert np.abs(np.array(gravity(q)) - rest).max() <= 1e-12 * max(1, np.abs(rest).max())
        if about["linear"]:
            push = np.array(inverse_dynamics(q, still, a)) - rest
            assert np.abs(np.array(mass_matrix(q)) @ a - push).max() <= 1e-11 * max(1, np.abs(push).max()), (np.array(mass_matrix(q)) @ a, push)
    return np.array([inverse_dynamics(*s) for s in states])


def of_samples(about):
    """What is measured beside the motion, a dictionary per sample."""
    return [{name: values[s] for name, values in about["channels"].items()} for s in range(len(about["q"]))]


def order(path, about):
    """Names of the further quantities as both files have them, which C takes by their places."""
    names = loaded_python(path.with_suffix(".py")).CHANNELS
    assert sorted(names) == sorted(about["channels"])
    [line] = [line for line in path.with_suffix(".c").read_text().splitlines() if "Further quantities that effects depend on: " in line]
    places = [line.index(f" {name} (") for name in names]
    assert places == sorted(places), line
    return names


def python_at(path, about, states):
    model, out = loaded_python(path), []
    for state, channels in zip(states, of_samples(about)):
        out.append(functions(*(lambda *s, f=f: f(*s, channels) for f in (model.inverse_dynamics, model.gravity, model.mass_matrix)), about, [state])[0])
    return np.array(out)


def python_nothing(path, about, states):
    """A dictionary without the names counts as none."""
    model = loaded_python(path)
    return np.array([model.inverse_dynamics(*s, channels={"other": 3.0}) for s in states])


def c_of(path, about, states, rows):
    loaded, n, prefix, out = loaded_c(path), len(about["joints"]), about["prefix"], []
    array = lambda values: (ctypes.c_double * len(values))(*values)

    def at(name, size, channels, *values):
        tau = array([0.0] * size)
        getattr(loaded, f"{prefix}_{name}_at")(*(array(v) for v in values), array(channels), tau)
        return np.array(tau)

    for state, row in zip(states, rows):
        out.append(functions(lambda *s: at("inverse_dynamics", n, row, *s), lambda q: at("gravity", n, row, q), lambda q: at("mass_matrix", n * n, row, q).reshape(n, n), about, [state])[0])
    return np.array(out)


def c_at(path, about, states):
    return c_of(path, about, states, [[row[name] for name in order(path, about)] for row in of_samples(about)])


def c_nan(path, about, states):
    return c_of(path, about, states, [[float("nan")] * len(about["channels"])] * len(states))


def python_predict_at(path, about, states):
    model = loaded_python(path)
    predicted = np.array(model.predict(*zip(*states), INTERVAL, about["channels"]))
    stepper = model.Stepper(INTERVAL)
    stepped = np.array([stepper.step(*s, channels) for s, channels in zip(states, of_samples(about))])
    same_as_without(stepped, predicted, python_step(path, about, states), python_predict(path, about, states))
    return predicted


def c_predict_at(path, about, states):
    loaded, prefix, n = loaded_c(path), about["prefix"], len(about["joints"])
    tau, stepped = np.empty((len(states), n)), []
    channels = np.ascontiguousarray(np.array([about["channels"][name] for name in order(path, about)]).T)
    arrays = [np.ascontiguousarray(v) for v in zip(*states)] + [channels, tau]
    pointer = lambda values: values.ctypes.data_as(ctypes.c_void_p)
    assert getattr(loaded, f"{prefix}_predict_at")(ctypes.c_long(len(states)), ctypes.c_double(INTERVAL), *map(pointer, arrays)) == 0
    size = getattr(loaded, f"{prefix}_state_size")
    size.restype = ctypes.c_size_t
    state, row = ctypes.create_string_buffer(size()), np.empty(n)
    assert getattr(loaded, f"{prefix}_reset")(state, ctypes.c_double(INTERVAL)) == 0
    for s, values in zip(states, channels):
        getattr(loaded, f"{prefix}_step_at")(state, *(pointer(np.ascontiguousarray(v)) for v in s), pointer(np.ascontiguousarray(values)), pointer(row))
        stepped.append(row.copy())
    same_as_without(np.array(stepped), tau, c_step(path, about, states), c_predict(path, about, states))
    return tau


def same_as_without(stepped, predicted, stepped_without, predicted_without):
    """The quantities change what is predicted step by step as they change the whole."""
    steps, whole = stepped - stepped_without, predicted - predicted_without
    assert np.abs(whole).max() > 0.1 and np.abs(steps - whole).max() < 0.05 * np.abs(whole).max(), (np.abs(steps - whole).max(), np.abs(whole).max())


READERS = {"urdf": (urdf, "urdf"), "patched_urdf": (urdf, "patched.urdf"), "sdf": (sdf, "sdf"), "mjcf": (mjcf, "xml"), "c": (c, "c"), "python": (python, "py"),
    "c_predict": (c_predict, "c"), "c_step": (c_step, "c"), "python_predict": (python_predict, "py"), "python_step": (python_step, "py"),
    "c_at": (c_at, "c"), "c_nan": (c_nan, "c"), "c_predict_at": (c_predict_at, "c"), "python_at": (python_at, "py"), "python_nothing": (python_nothing, "py"),
    "python_predict_at": (python_predict_at, "py")}
result = {}
for folder in sorted(p for p in Path(sys.argv[1]).iterdir() if p.is_dir()):
    about = json.loads((folder / "states.json").read_text())
    states = [tuple(np.array(about[k][s]) for k in ("q", "qd", "qdd")) for s in range(len(about["q"]))]
    for name, expected in about["expected"].items():
        read, ending = READERS[name]
        found = read(folder / f"model.{ending}", about, states)
        difference = np.abs(found - np.array(expected))
        result.setdefault(folder.name, {})[name] = {"max": difference.max(0).tolist(), "rms": np.sqrt((difference**2).mean(0)).tolist(), "later": float(difference[100:-100].max(initial=0.0)), "size": float(np.abs(expected).max())}
print(json.dumps(result))
