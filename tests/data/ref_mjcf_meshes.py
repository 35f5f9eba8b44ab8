"""Sixteen MJCF files with meshes, and where MuJoCo puts their points: `python ref_mjcf_meshes.py > ref_mjcf_meshes.json`.

Meshes are distorted boxes of eight points. They are scaled, mirrored, turned (`refquat`) and moved (`refpos`), named or not, in folders that the compiler names; geoms get
types, meshes, places and masks from default classes, and stand in frames, with orientations of every kind. Some bodies have their meshes to be seen alone, some
a shape of their own beside them. Joints and inertials stand in frames too.
"""
import json
import pathlib
import random
import tempfile

import mujoco
import numpy as np

VARIANTS = 16
# Corners by their bits (x, y, z), faces seen from outside against the clock.
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
TRIANGLES = [t for a, b, c, d in FACES for t in ((a, b, c), (a, c, d))]


class Variant:
    def __init__(self, index):
        self.rng = random.Random(index)
        self.angle = self.rng.choice(["degree", "radian"])
        self.files, self.names = {}, []
        self.folder, compiler = self.folders()
        self.text = (f'<mujoco model="variant {index}"><compiler angle="{self.angle}" eulerseq="{self.rng.choice(["xyz", "ZYX", "zxz", "XyZ"])}" {compiler} strippath="{str(self.strip).lower()}"/>'
                     f'<option gravity="0.3 -0.2 -9.7"/>{self.defaults()}')
        assets = "".join(self.asset(k) for k in range(6))
        arm = self.body(0, self.rng.randint(2, 4))
        self.text += f"<asset>{assets}</asset><worldbody><geom type=\"mesh\" mesh=\"{self.names[0]}\"/>{arm}</worldbody></mujoco>"

    def folders(self):
        self.strip = self.rng.random() < 0.3
        return self.rng.choice([("", ""), ("meshes/", 'meshdir="meshes"'), ("parts/", 'assetdir="parts/"'), ("meshes/", 'assetdir="parts" meshdir="meshes/"'), ("../shared/", 'meshdir="../shared"')])

    def numbers(self, count, size=1.0):
        return " ".join(f"{self.rng.uniform(-size, size):.5f}" for _ in range(count))

    def turn(self):
        angle = lambda: f"{self.rng.uniform(-2, 2) * (57.29578 if self.angle == 'degree' else 1):.5f}"
        return self.rng.choice([lambda: "", lambda: f'quat="{self.numbers(4)}"', lambda: f'euler="{angle()} {angle()} {angle()}"', lambda: f'axisangle="{self.numbers(3)} {angle()}"',
                                lambda: f'xyaxes="{self.numbers(6)}"', lambda: f'zaxis="{self.numbers(3)}"'])()

    def place(self, size=0.3):
        return self.rng.choice(["", f'pos="{self.numbers(3, size)}"']) + " " + self.turn()

    def defaults(self):
        first = self.rng.choice(['scale="0.9 1.1 1.2"', ""])
        return (f'<default><mesh {first}/><geom {self.place()}/><joint {self.rng.choice(["", "axis=" + chr(34) + self.numbers(3) + chr(34)])}/>'
                f'<default class="seen"><geom type="mesh" contype="0" conaffinity="0" {self.turn()}/><mesh scale="0.001 0.001 0.001"/></default>'
                f'<default class="touched"><geom type="mesh" mesh="m0" {self.place()}/><default class="deeper"><geom {self.place()}/></default></default></default>')

    def asset(self, k):
        half = [self.rng.uniform(0.03, 0.2) for _ in range(3)]
        off = [self.rng.uniform(-0.1, 0.1) for _ in range(3)]
        millimetres = self.rng.random() < 0.3
        unit = 1000 if millimetres else 1
        corner = lambda c: [round(unit * (o + h * (1 if c >> i & 1 else -1) * self.rng.uniform(0.8, 1.2)), 5) for i, (h, o) in enumerate(zip(half, off))]
        format = self.rng.choice(["obj", "stl"])
        file = f"part{k}.{format}"
        self.files[f"model/{self.folder}{file}"] = {"format": format, "corners": [corner(c) for c in range(8)]}
        named = k == 0 or self.rng.random() < 0.5
        self.names.append(f"m{k}" if named else f"part{k}")
        written = f"somewhere/else/{file}" if self.strip else file
        scale = self.rng.choice(["", f'scale="{self.rng.uniform(0.5, 1.5):.4f} {self.rng.uniform(-1.5, -0.5):.4f} 1"'])
        scale = 'class="seen"' if millimetres else scale
        reference = self.rng.choice(["", f'refpos="{self.numbers(3, 0.1 * unit)}"', f'refquat="{self.numbers(4)}"', f'refpos="{self.numbers(3, 0.1 * unit)}" refquat="{self.numbers(4)}"'])
        return f'<mesh {f"name={chr(34)}m{k}{chr(34)}" if named else ""} file="{written}" {scale} {reference}/>'

    def geom(self, kind):
        mesh = self.rng.choice(self.names)
        return {
            "class": lambda: f'<geom class="{self.rng.choice(["touched", "deeper"])}" {self.place()}/>',
            "mesh": lambda: f'<geom type="mesh" mesh="{mesh}" {self.place()}/>',
            "seen": lambda: f'<geom class="seen" mesh="{mesh}" {self.place()}/>',
            "one mask": lambda: f'<geom class="seen" conaffinity="2" mesh="{mesh}" {self.place()}/>',
            "ball": lambda: '<geom size="0.07" pos="0.01 0.02 0.03"/>',
        }[kind]()

    def within(self, inside):
        if self.rng.random() < 0.6:
            return inside
        return f'<frame {self.place()} {self.rng.choice(["", "childclass=" + chr(34) + "deeper" + chr(34)])}>{inside}</frame>'

    def body(self, k, bodies):
        kinds = self.rng.choice([["mesh"], ["class", "seen"], ["seen", "one mask", "mesh"], ["seen", "seen"], ["ball", "mesh"], ["class"] * 5, []])
        geoms = "".join(self.within(self.geom(kind)) for kind in kinds)
        joint = self.within(f'<joint name="j{k}" {self.rng.choice(["", "type=" + chr(34) + "slide" + chr(34)])} pos="{self.numbers(3, 0.1)}" axis="{self.numbers(3)}"/>')
        inertial = self.within(f'<inertial pos="{self.numbers(3, 0.1)}" mass="{self.rng.uniform(1, 4):.3f}" diaginertia="0.02 0.025 0.03" {self.turn()}/>')
        tool = f'<body name="tool" {self.place()}><inertial pos="0 0 0.1" mass="0.5" diaginertia="0.001 0.001 0.001"/>{self.geom("mesh")}</body>' if k + 1 == bodies else ""
        further = self.body(k + 1, bodies) if k + 1 < bodies else ""
        named = f'name="b{k}"' if self.rng.random() < 0.7 else ""
        return f'<body {named} pos="{self.numbers(3, 0.4)}" {self.turn()}>{joint}{inertial}{geoms}{self.within(further + tool)}</body>'

    def content(self, file):
        if file["format"] == "obj":
            return ("".join(f"v {x} {y} {z}\n" for x, y, z in file["corners"]) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in TRIANGLES)).encode()
        triangle = lambda t: bytes(12) + np.array([file["corners"][i] for i in t], "<f4").tobytes() + bytes(2)
        return bytes(80) + np.uint32(len(TRIANGLES)).tobytes() + b"".join(map(triangle, TRIANGLES))


def points(model, geom):
    """Vertices of a mesh in the frame of its geom, whose place is given where MuJoCo has put it."""
    mesh = model.geom_dataid[geom]
    start = model.mesh_vertadr[mesh]
    return model.mesh_vert[start:start + model.mesh_vertnum[mesh]].astype(float)


def moved(position, matrix, rows):
    return rows @ np.reshape(matrix, (3, 3)).T + position


def meshes(model, body):
    """Geoms of the meshes that describe a body: none beside a shape of its own that collides."""
    geoms = [g for g in range(model.ngeom) if model.geom_bodyid[g] == body]
    collides = lambda g: bool(model.geom_contype[g] or model.geom_conaffinity[g])
    is_mesh = lambda g: model.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH
    if any(collides(g) and not is_mesh(g) for g in geoms):
        return []
    return [g for g in geoms if collides(g)] or geoms


def mover(model, body):
    while model.body_jntnum[body] == 0:
        body = model.body_parentid[body]
    return mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, model.body_jntadr[body])


def listed(rows):
    return np.round(rows, 7).tolist()


def reference(index):
    variant = Variant(index)
    files = {name.replace("model/../", ""): file for name, file in variant.files.items()}
    with tempfile.TemporaryDirectory() as folder:
        for name, content in [("model/arm.xml", variant.text.encode()), *((name, variant.content(file)) for name, file in files.items())]:
            path = pathlib.Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        model = mujoco.MjModel.from_xml_path(str(pathlib.Path(folder, "model/arm.xml")))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    draw = np.random.default_rng(index)
    data.qpos[:], data.qvel[:], data.qacc[:] = (draw.uniform(-s, s, model.nv) for s in (0.8, 1, 2))
    mujoco.mj_inverse(model, data)
    bodies, seen = [], []
    for body in range(1, model.nbody):
        here = meshes(model, body)
        place = np.zeros(9)
        own = []
        for g in here:
            mujoco.mju_quat2Mat(place, model.geom_quat[g])
            own.append(listed(moved(model.geom_pos[g], place, points(model, g))))
            world = moved(data.geom_xpos[g], data.geom_xmat[g], points(model, g))
            seen.append({"joint": mover(model, body), "points": listed(world)})
        bodies.append({"body": mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body), "meshes": own})
    state = {"q": data.qpos.tolist(), "qd": data.qvel.tolist(), "qdd": data.qacc.tolist(), "torque": data.qfrc_inverse.tolist(), "seen": seen}
    return {"mjcf": variant.text, "files": files, "bodies": bodies, "state": state}


print(json.dumps({"mujoco": mujoco.__version__, "variants": [reference(k) for k in range(VARIANTS)]}, indent=None).replace('{"mjcf"', '\n{"mjcf"'))
