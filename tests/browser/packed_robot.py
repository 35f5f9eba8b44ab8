"""A robot as one ZIP archive with its meshes: chosen as MJCF, dropped as URDF; its links have the shapes of the meshes, in the editor and when it is kept.
Archives that hold no robot are refused in words."""

import base64
import json
import math
import urllib.request
import zipfile

from browser import arguments, browser_page, check, picture

SIDES = 12


def tube(radius, low, high):
    """A prism around z as a Wavefront OBJ file."""
    turn = [2 * math.pi * k / SIDES for k in range(SIDES)]
    rings = [(radius * math.cos(a), radius * math.sin(a), z) for z in (low, high) for a in turn]
    sides = [(k + 1, (k + 1) % SIDES + 1, SIDES + (k + 1) % SIDES + 1, SIDES + k + 1) for k in range(SIDES)]
    ends = [tuple(range(SIDES, 0, -1)), tuple(range(SIDES + 1, 2 * SIDES + 1))]
    lines = ["v {:.6f} {:.6f} {:.6f}".format(*p) for p in rings] + ["f " + " ".join(map(str, face)) for face in sides + ends]
    return "\n".join(lines) + "\n"


MESHES = {"column.obj": tube(90, -50, 250), "upper_arm.obj": tube(70, 0, 420), "forearm.obj": tube(55, 0, 380), "wrist.obj": tube(40, -40, 90)}
# Of millimetres, with the forearm along x of its body, the wrist seen alone, and a tool whose mesh is not there.
MJCF = """<mujoco model="packed bench"><compiler angle="degree" meshdir="assets"/>
<default><mesh scale="0.001 0.001 0.001"/><joint axis="0 1 0" range="-120 120"/><default class="seen"><geom type="mesh" contype="0" conaffinity="0"/></default></default>
<asset><mesh file="column.obj"/><mesh file="upper_arm.obj"/><mesh file="forearm.obj" refquat="0.70710678 0 0.70710678 0"/><mesh file="wrist.obj"/><mesh file="gripper.stl"/></asset>
<worldbody><body name="column" pos="0 0 0.1"><inertial pos="0 0 0.1" mass="6" diaginertia="0.05 0.05 0.03"/><joint name="turn" axis="0 0 1"/><geom type="mesh" mesh="column"/>
<body name="upper" pos="0 0.15 0.25"><inertial pos="0 0 0.2" mass="4" diaginertia="0.06 0.06 0.01"/><joint name="lift"/><geom type="mesh" mesh="upper_arm"/>
<body name="fore" pos="0 -0.12 0.42" euler="0 90 0"><inertial pos="-0.2 0 0" mass="3" diaginertia="0.01 0.04 0.04"/><joint name="bend"/><geom type="mesh" mesh="forearm" euler="0 90 0"/>
<body name="hand" pos="0 0.1 0.4"><inertial pos="0 0 0.03" mass="1" diaginertia="0.002 0.002 0.001"/><joint name="roll" axis="0 0 1"/><geom class="seen" mesh="wrist"/>
<body name="tool"><inertial pos="0 0 0.1" mass="0.4" diaginertia="0.001 0.001 0.001"/><geom type="mesh" mesh="gripper"/></body>
</body></body></body></body></worldbody></mujoco>"""
URDF = """<robot name="packed arm"><link name="base"/>
<link name="l1"><inertial><mass value="3"/><inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><mesh filename="package://packed_arm/meshes/column.obj" scale="0.001 0.001 0.001"/></geometry></visual></link>
<link name="l2"><inertial><mass value="2"/><inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0 0 0.05"/><geometry><mesh filename="package://packed_arm/meshes/upper_arm.obj" scale="0.001 0.001 0.001"/></geometry></collision></link>
<joint name="j1" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/></joint>
<joint name="j2" type="continuous"><origin xyz="0 0 0.3"/><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/></joint></robot>"""


def packed(path, files):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return path


def adding(page, options):
    page.goto(options.server)
    page.get_by_role("link", name="Add a robot").click()
    page.locator("#source-file").wait_for()


def numbers(page, joint, k, name, count):
    return [float(page.input_value(f"[data-pointer='/robot/joints/{joint}/geometry/{k}/{name}{f'/{i}' if count > 1 else ''}']")) for i in range(count)]


def chosen(page, options):
    adding(page, options)
    archive = packed(page.folder / "bench.zip", {"bench/bench.xml": MJCF, **{f"bench/assets/{name}": text for name, text in MESHES.items()}})
    page.set_input_files("#source-file", archive)
    page.locator("#editor .notice").get_by_text("assets/gripper.stl").wait_for()
    page.locator(".picture canvas[data-drawn]").wait_for()
    # Shapes are there, and none is suggested.
    assert page.locator("#editor .notice").get_by_text("Capsules along the links are suggested").count() == 0
    assert page.locator("#editor .tag", has_text="capsule").count() == 4
    assert abs(numbers(page, 0, 0, "radius", 1)[0] - 0.09) < 1e-6
    # The forearm's mesh, turned and turned back: from its joint along the axis of its body.
    low, high = sorted(numbers(page, 2, 0, name, 3) for name in ["from", "to"])
    # The round ends of a capsule contain the rims of the prism.
    assert all(abs(a - b) < 1e-6 for a, b in zip(low + high, [0, 0, 0, 0, 0, 0.38])), (low, high)
    page.wait_for_function("() => document.querySelector('.picture canvas').width > 100")
    check(page, "editor of a packed robot")
    picture(page, options, "packed-editor")
    picture(page, options, "packed-picture", ".picture")
    page.get_by_role("button", name="Save robot").click()
    page.locator("#kinematics canvas[data-drawn]").wait_for()
    assert page.url.endswith("/robot?robot=packed-bench"), page.url
    with urllib.request.urlopen(f"{options.server}/robots/packed-bench") as answer:
        kept = json.load(answer)
    assert [len(joint["geometry"]) for joint in kept["joints"]] == [1, 1, 1, 1]
    check(page, "packed robot")
    picture(page, options, "packed-robot", "#kinematics")


def dropped(page, options):
    adding(page, options)
    archive = packed(page.folder / "arm.zip", {"packed_arm/package.xml": "<package/>", "packed_arm/urdf/arm.urdf": URDF, "packed_arm/meshes/column.obj": MESHES["column.obj"],
                                              "packed_arm/meshes/upper_arm.obj": MESHES["upper_arm.obj"]})
    page.evaluate("""content => {
        const bytes = Uint8Array.from(atob(content), c => c.charCodeAt(0));
        const dataTransfer = new DataTransfer();
        dataTransfer.items.add(new File([bytes], 'arm.zip'));
        document.querySelector('.drop').dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    }""", base64.b64encode(archive.read_bytes()).decode())
    page.locator(".picture canvas[data-drawn]").wait_for()
    assert page.locator("#editor .tag", has_text="capsule").count() == 2
    ends = sorted(numbers(page, 1, 0, name, 3)[2] for name in ["from", "to"])
    radius = numbers(page, 1, 0, "radius", 1)[0]
    assert abs(radius - 0.07) < 1e-6 and abs(ends[0] - 0.05) < 1e-6 and abs(ends[1] - 0.47) < 1e-6, (ends, radius)


def refused(page, options):
    adding(page, options)
    for name, files, words in [("empty.zip", {"readme.txt": "nothing"}, "has no robot"), ("two.zip", {"a.urdf": URDF, "b.urdf": URDF}, "has 2 robots")]:
        page.set_input_files("#source-file", packed(page.folder / name, files))
        page.locator("#source [role=alert]").get_by_text(words).wait_for()
    check(page, "refused archive")
    picture(page, options, "packed-refused")
    # What the console says of the refused requests is what was asked for here.
    page.trouble.clear()


def main():
    options = arguments()
    with browser_page(options) as page:
        chosen(page, options)
        dropped(page, options)
        refused(page, options)


main()
