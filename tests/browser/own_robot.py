"""A robot that is not shipped and a log that no program here has written: from the start page to a validated model, in less than three minutes; with what
is wrong on the way said in words. On a laptop a DH table and a table of a controller of its own kind; on a phone a URDF file and a log as RTDE clients write it,
with motor currents."""

import csv
import json
import math
import random
import time
import urllib.request
from pathlib import Path

from browser import arguments, browser_page, check, check_error, picture, settle, simulate

# Three links with friction: mass, centre of mass, inertia about it, viscous and Coulomb friction.
LINKS = [(4.0, (0.0, -0.05, 0.02), 0.03, 0.8, 1.2), (3.0, (-0.2, 0.01, 0.05), 0.04, 0.6, 0.9), (1.2, (-0.1, 0.0, 0.03), 0.01, 0.2, 0.4)]
LONGEST_S = 180
PANDA = Path(__file__).parent / "panda.urdf"
NM_PER_AMPERE = 10


def standard(link):
    mass, (x, y, z), i, viscous, coulomb = link
    return [mass, mass * x, mass * y, mass * z, i + mass * (y * y + z * z), -mass * x * y, -mass * x * z, i + mass * (x * x + z * z), -mass * y * z, i + mass * (x * x + y * y), viscous, coulomb]


def foreign_log(options, robot, folder, seed, name):
    """As a controller of its own kind writes it: degrees, milliseconds, spaces, torques by letters, and a column of text."""
    draw = random.Random(seed)
    rows = [[draw.uniform(-0.4, 0.4) for _ in range(3)] for _ in range(3)]
    request = {"parameters": [v for link in LINKS for v in standard(link)], "trajectory": {"fourier": {"fundamental_hz": 0.2, "a": rows, "b": rows[::-1]}}, "periods": 3,
               "sample_rate_hz": 1000, "noise": {"torque": [0.2, 0.2, 0.1]}, "seed": seed}
    plain = simulate(options, str(robot), request, folder / f"plain-{name}")
    with plain.open() as source, (folder / name).open("w") as out:
        out.write("clock_ms pos.1 pos.2 pos.3 trq_base trq_arm trq_wrist mode\n")
        for row in csv.DictReader(source):
            q = [f"{math.degrees(float(row[f'q{j}'])):.9f}" for j in (1, 2, 3)]
            tau = [f"{float(row[f'tau{j}']):.6f}" for j in (1, 2, 3)]
            out.write(" ".join([f"{5000 + 1000 * float(row['time']):.3f}", *q, *tau, "AUTO"]) + "\n")
    return folder / name


def describe(page, options):
    page.goto(options.server)
    page.get_by_role("link", name="Add a robot").click()
    page.check("input[value=dh]")
    page.fill("#dh-name", "Bench arm")
    page.fill("#dh-count", "3")
    page.locator("#dh-count").blur()
    page.select_option("#dh-convention", "standard")
    check(page, "dh")
    table = [["0", "0.3", "0", "pi/2"], ["0", "0", "0.4", "0"], ["0", "0", "0.3", "x"]]
    page.select_option("#dh-unit", "rad")
    for j, row in enumerate(table):
        for key, value in zip(["theta", "d", "a", "alpha"], row):
            page.fill(f"[data-row='{j}'][data-key={key}]", value)
    page.get_by_role("button", name="Use this table").click()
    # What is no number is named by its place.
    page.locator("#source [role=alert]").get_by_text("J3: αᵢ is “x”").wait_for()
    page.fill("[data-row='2'][data-key=alpha]", "0")
    page.get_by_role("button", name="Use this table").click()
    page.locator("#editor").wait_for()
    # The second modified row begins with a and α of the first standard one.
    assert page.input_value("[data-pointer='/robot/joints/1/mdh/alpha']") == "90"
    assert page.input_value("[data-pointer='/robot/joints/2/mdh/d']") == "0.4"
    edit(page, options)


def edit(page, options):
    for j in range(3):
        place = page.locator(f"[data-pointer='/robot/joints/{j}/limits/position']")
        place.nth(0).fill("-160")
        place.nth(1).fill("160")
        page.fill(f"[data-pointer='/robot/joints/{j}/limits/velocity']", "120")
    page.fill("[data-pointer='/robot/joints/1/limits/velocity']", "fast")
    page.get_by_role("button", name="Save robot").click()
    # At the field, and at the button.
    speed = "[data-pointer='/robot/joints/1/limits/velocity']"
    page.locator(f"td:has({speed}) .field-error").wait_for()
    check_error(page, f"td:has({speed}) .field-error", "#editor [role=alert]", "J2: velocity is “fast”, expected a number.", speed)
    page.trouble.clear()
    page.fill("[data-pointer='/robot/joints/1/limits/velocity']", "120")
    page.locator("#joint-1 summary").click()
    # It had no shape, and got one along its links.
    page.locator("#editor .notice").get_by_text("Capsules along the links are suggested").wait_for()
    assert page.input_value("[data-pointer='/robot/joints/1/geometry/0/to/0']") == "0.4"
    page.get_by_role("button", name="Suggest a shape").click()
    # Only the second link is long enough, and it has a shape already.
    assert page.locator("#editor .tag", has_text="capsule").count() == 1
    page.locator("#tool-part summary").click()
    page.fill("#tool-mass", "2")
    page.fill("#tool-z", "0.1")
    page.get_by_role("button", name="Add to the last link").click()
    assert page.input_value("[data-pointer='/robot/joints/2/prior/mass']") == "2"
    page.locator("#joint-2 summary").click()
    page.select_option("#mounting", label="Hanging from the ceiling")
    assert page.input_value("[data-pointer='/robot/gravity/2']") == "9.81"
    page.select_option("#mounting", label="On the floor")
    # A tool that was only tried: taken off again.
    page.locator("#joint-2 fieldset input[type=checkbox]").first.uncheck()
    page.wait_for_function("() => !document.querySelector('.field-error') && document.querySelector('.picture canvas').width > 100")
    check(page, "editor")
    picture(page, options, "editor")
    page.get_by_role("button", name="Save robot").click()
    page.locator("#kinematics").wait_for()
    assert page.url.endswith("/robot?robot=bench-arm"), page.url
    with urllib.request.urlopen(f"{options.server}/robots/bench-arm") as answer:
        kept = json.load(answer)
    assert abs(kept["joints"][0]["limits"]["position"][1] - math.radians(160)) < 1e-12 and abs(kept["joints"][1]["mdh"]["alpha"] - math.pi / 2) < 1e-12
    assert len(kept["joints"][1]["geometry"]) == 1 and "prior" not in kept["joints"][2]
    return kept


def map_columns(page, options, log, other):
    page.get_by_role("link", name="Identify", exact=True).click()
    page.locator("#robot option").first.wait_for(state="attached")
    assert page.input_value("#robot") == "bench-arm"
    page.set_input_files("#log", log)
    page.locator("#columns").wait_for()
    # Positions and time are guessed from names and sizes; torques by letters are not.
    assert page.input_value("#unit-position") == "deg" and page.input_value("#unit-time") == "ms"
    assert "no torque for any joint" in page.locator("#columns .notice").inner_text()
    page.click("#go")
    page.locator("#form-trouble").get_by_text("The columns are not complete").wait_for()
    for header, joint in [("trq_base", "J1"), ("trq_arm", "J2"), ("trq_wrist", "J3")]:
        page.get_by_label(f"{header}: used as").select_option(label=f"torque {joint}")
    page.locator("#result h2", has_text=log.name).wait_for()
    page.set_input_files("#validation", other)
    page.locator("#result h2", has_text=other.name).wait_for()
    assert "1,000 Hz" in page.locator("#result").inner_text().replace("\n", " ") or "1000 Hz" in page.locator("#result").inner_text().replace("\n", " ")
    settle(page)
    check(page, "columns")
    picture(page, options, "columns", "#columns-place")


def identified(page, robot):
    page.click("#go")
    page.locator("#torques").wait_for(timeout=120_000)
    name = page.url.split("id=")[1]
    assert page.input_value("#robot") == robot, "the form keeps the robot"
    assert page.locator("#verdict").inner_text(), "the verdict comes first"
    return name


def panda_log(options, folder, seed, name):
    """As RTDE clients write it: a time since the controller started, zeros where nothing is measured, and motor currents."""
    draw = random.Random(seed)
    rows = [[draw.uniform(-0.2, 0.2) for _ in range(3)] for _ in range(7)]
    series = {"fundamental_hz": 0.1 + 0.025 * seed, "a": rows, "b": rows[::-1], "offset": [0, 0, 0, -1.6, 0, 1.8, 0]}
    request = {"trajectory": {"fourier": series}, "periods": 3, "sample_rate_hz": 1000, "noise": {"torque": [0.2] * 4 + [0.06] * 3}, "seed": seed}
    plain = simulate(options, str(PANDA), request, folder / f"plain-{name}")
    with plain.open() as source, (folder / name).open("w") as out:
        out.write(" ".join(["timestamp", *(f"{what}_{j}" for what in ["actual_q", "actual_qd", "actual_current"] for j in range(7))]) + "\n")
        for row in csv.DictReader(source):
            currents = [f"{float(row[f'tau{j}']) / NM_PER_AMPERE:.6f}" for j in range(1, 8)]
            out.write(" ".join([f"{1000 + float(row['time']):.4f}", *[row[f"q{j}"] for j in range(1, 8)], *["0"] * 7, *currents]) + "\n")
    return folder / name


def describe_panda(page, options):
    page.goto(options.server)
    page.get_by_role("link", name="Add a robot").click()
    page.set_input_files("#source-file", PANDA)
    page.locator("#editor .notice").get_by_text("Capsules along the links are suggested").wait_for()
    page.locator(".picture canvas[data-drawn]").wait_for()
    check(page, "editor")
    picture(page, options, "editor-urdf")
    page.get_by_role("button", name="Save robot").click()
    page.locator("#kinematics canvas[data-drawn]").wait_for()
    assert page.url.endswith("/robot?robot=bench_panda"), page.url


def meshes(page, options):
    """A mesh in millimetres, which the URDF file puts on the third link; and files that are none."""
    corners = [(0, 0, 0), (80, 0, 0), (0, 80, 0), (0, 0, 200)]
    facets = [[corners[i] for i in face] for face in [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]]
    solid = "".join("facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in facet) + "endloop\nendfacet\n" for facet in facets)
    (page.folder / "forearm.stl").write_text(f"solid forearm\n{solid}endsolid forearm\n")
    (page.folder / "broken_panda_joint1.stl").write_bytes(b"solid")
    page.locator("#meshes summary").click()
    page.set_input_files("#mesh-files", page.folder / "forearm.stl")
    page.locator("#meshes .field-error").get_by_text("names no joint of this robot").wait_for()
    page.set_input_files("#mesh-files", [page.folder / "forearm.stl", page.folder / "broken_panda_joint1.stl", PANDA])
    page.locator("#meshes").get_by_text("1 mesh kept in this browser").wait_for()
    page.locator("#meshes .field-error").get_by_text("broken_panda_joint1.stl cannot be read").wait_for()
    # Kept: there again when the page is.
    page.reload()
    page.locator("#kinematics canvas[data-meshes='1']").wait_for()
    check(page, "meshes")
    picture(page, options, "meshes", "#kinematics")


def map_currents(page, options, log, other):
    page.get_by_role("link", name="Identify", exact=True).click()
    page.locator("#robot option").first.wait_for(state="attached")
    page.set_input_files("#log", log)
    page.locator("#columns .tag", has_text="Universal Robots RTDE").wait_for()
    assert "no N·m per ampere for any joint" in page.locator("#columns .notice").first.inner_text()
    page.fill("#scale-all", str(NM_PER_AMPERE))
    page.locator("#scale-all").blur()
    page.locator("#result h2", has_text=log.name).wait_for()
    page.set_input_files("#validation", other)
    page.locator("#result h2", has_text=other.name).wait_for()
    settle(page)
    check(page, "currents")
    picture(page, options, "currents", "#columns-place")


def designed(page, options):
    """The robot avoids itself and the floor; where it comes nearest is drawn."""
    page.goto(f"{options.server}/design?robot=bench_panda")
    page.wait_for_function("() => document.querySelector('#as-request')?.textContent.includes('half_spaces')")
    page.fill("#time-limit", "3")
    page.click("#go")
    page.locator("#path").wait_for()
    page.get_by_role("button", name="Show the closest approach").click()
    page.locator("#path canvas[data-drawn]").wait_for()
    assert page.locator("#clearances tbody tr").count() >= 2
    page.locator("#path canvas").focus()
    for key in ["+", "ArrowLeft", "0"]:
        page.keyboard.press(key)
    settle(page)
    check(page, "closest approach")
    picture(page, options, "closest", "#path")


def paper(page):
    """What is dark on the screen is printed light, plots included."""
    look = "() => [getComputedStyle(document.documentElement).colorScheme, document.querySelector('#parameters .plot').layout?.font.color]"
    page.wait_for_function("() => document.querySelector('#parameters .plot .main-svg')")
    assert page.evaluate(look) == ["dark", "#eceff2"], page.evaluate(look)
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.evaluate(look) == ["light", "#16191d"], page.evaluate(look)
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.evaluate(look) == ["dark", "#eceff2"], page.evaluate(look)


def compared(page, options, robot, log, other, first):
    """A second identification, and both side by side: named, found, compared, printed, deleted."""
    page.goto(f"{options.server}/identification?robot={robot}")
    page.locator("#robot option").first.wait_for(state="attached")
    # The next log with the same columns is read as the last one was.
    page.set_input_files("#log", other)
    page.locator("#result h2", has_text=other.name).wait_for()
    assert page.locator("#columns .notice").count() == 0
    page.set_input_files("#validation", log)
    page.locator("#result h2", has_text=log.name).wait_for()
    second = identified(page, robot)
    page.get_by_role("link", name="Runs", exact=True).click()
    for name, words in [(first, "First try"), (second, "Second try")]:
        page.get_by_role("button", name=f"Edit name and note of {name[:8]}").click()
        page.fill("#edit-name", words)
        page.fill("#edit-note", "new grease")
        page.get_by_role("button", name="Save", exact=True).click()
        page.locator("#list").get_by_role("link", name=words).wait_for()
    page.fill("#search", "SECOND")
    page.wait_for_function("() => document.querySelectorAll('#list tbody tr').length === 1")
    assert "search=SECOND" in page.url
    # By the name of a log as well, which the list shows.
    page.fill("#search", log.name)
    page.wait_for_function("() => document.querySelectorAll('#list tbody tr').length === 2")
    assert page.locator("#list .logs").first.inner_text() == f"{other.name}, {log.name}"
    page.fill("#search", "")
    page.get_by_label("Select Second try").wait_for()
    page.get_by_label("Select First try").check()
    page.get_by_label("Select Second try").check()
    page.click("#compare")
    page.locator("#parameters .plot").wait_for()
    settle(page)
    check(page, "comparison")
    picture(page, options, "comparison", "#comparison")
    assert page.locator("#parameters .errorbar").count() >= 2
    assert page.locator("#errors tbody tr").count() == 4
    # The address says it all: to be shared.
    page.goto(page.url)
    page.locator("#time .plot").wait_for(state="attached")
    # Nothing was scrolled to: what is printed is drawn for it.
    page.wait_for_function("() => window.Plotly")
    if options.width < 500:
        paper(page)
    printed = page.pdf()
    assert page.evaluate("[...document.querySelectorAll('.plot')].every(p => p.querySelector('.main-svg'))"), "all plots are printed"
    assert printed.startswith(b"%PDF") and len(printed) > 20_000
    page.get_by_role("button", name="Delete Second try").click()
    page.wait_for_function("() => document.querySelectorAll('#list tbody tr').length === 1")


def refusals(page, options, log):
    """Files that are no logs are named by what they are, and recordings that are show their columns."""
    binary = page.folder / "run.mcap"
    binary.write_bytes(b"\x89MCAP0\r\n" + bytes(200))
    plain = page.folder / "bare.csv"
    plain.write_text("0,1,2,3\n0.1,1,2,3\n")
    page.goto(f"{options.server}/identification?robot=bench-arm")
    page.locator("#robot option").first.wait_for(state="attached")
    page.set_input_files("#log", binary)
    page.locator("#trouble [role=alert]").get_by_text("no MCAP recording that can be read").wait_for()
    # What the console says of the refused request is what was asked for here.
    page.trouble.clear()
    recordings = Path(__file__).parent.parent / "data" / "logs" / "formats"
    for path, column in [(plain, "column4"), (recordings / "pandas.parquet", "tau2"), (recordings / "joint_states.mcap", "/joint_states/elbow/effort")]:
        page.set_input_files("#log", path)
        page.locator("#columns th", has_text=column).first.wait_for()
        # They are of another arm.
        page.locator("#columns .notice").first.wait_for()
    # The next log with the same columns is read as the last one was.
    page.set_input_files("#log", log)
    page.locator("#result h2", has_text=log.name).wait_for()
    assert page.locator("#columns .notice").count() == 0


def shipped_copy(page, options):
    page.goto(f"{options.server}/robot?robot=ur10")
    page.get_by_role("button", name="Edit a copy").click()
    page.locator("#editor").wait_for()
    page.fill("#robot-id", "iiwa14")
    page.get_by_role("button", name="Save robot").click()
    page.locator("#editor [role=alert]").get_by_text("comes with the program").wait_for()
    page.trouble.clear()
    # Its description has rows of a DH table: the editor has the modified parameters that the server makes of them.
    page.goto(f"{options.server}/robot?robot=ur5e")
    page.get_by_role("button", name="Edit a copy").click()
    page.locator("#editor .notice").get_by_text("Rows of DH tables are kept as modified parameters").wait_for()
    page.locator(".picture canvas[data-drawn]").wait_for()
    assert page.locator(".field-error").count() == 0 and page.input_value("[data-pointer='/robot/joints/1/mdh/alpha']") == "90"
    page.fill("#robot-id", "my-ur5e")
    page.get_by_role("button", name="Save robot").click()
    page.locator("#kinematics canvas[data-drawn]").wait_for()
    with urllib.request.urlopen(f"{options.server}/robots/my-ur5e") as answer:
        joints = json.load(answer)["joints"]
    assert len(joints) == 6 and all("dh" not in j and j["mdh"] and j["prior"]["mass"] > 0 for j in joints), joints
    # One without a shape avoids itself and a floor all the same, and starts where a motion is possible: stretched out, it is just
    # above the floor.
    for robot, starts in [("ur5e", "free"), ("iiwa7", "zero")]:
        page.goto(f"{options.server}/design?robot={robot}")
        page.wait_for_function("() => document.querySelector('#as-request')?.textContent.includes('half_spaces')")
        page.locator("#self-help", has_text="has no shape").wait_for(state="attached")
        asked = json.loads(page.locator("#as-request").text_content())["constraints"]
        assert asked["space"]["self_collision"] == {} and asked["start"] == starts, asked
        assert page.locator("#start-low").is_visible() == (starts == "free")
    check(page, "design without a shape")



def main():
    options = arguments()
    phone = options.width < 500
    with browser_page(options) as page:
        begun = time.monotonic()
        (describe_panda if phone else describe)(page, options)
        clicking = time.monotonic() - begun
        if phone:
            meshes(page, options)
        robot = "bench_panda" if phone else "bench-arm"
        if phone:
            log, other = (panda_log(options, page.folder, seed, name) for seed, name in [(0, "run.txt"), (1, "other.txt")])
        else:
            with urllib.request.urlopen(f"{options.server}/robots/bench-arm") as answer:
                (page.folder / "bench.json").write_bytes(answer.read())
            log, other = (foreign_log(options, page.folder / "bench.json", page.folder, seed, name) for seed, name in [(1, "run.txt"), (2, "other.txt")])
        begun = time.monotonic()
        (map_currents if phone else map_columns)(page, options, log, other)
        name = identified(page, robot)
        clicking += time.monotonic() - begun
        assert clicking < LONGEST_S, clicking
        with urllib.request.urlopen(f"{options.server}/identify/{name}?predictions=false") as answer:
            result = json.load(answer)
        errors = result["rms"]["validation"][0]["base"]["rms"]
        # Of single rows of at most 0.2 N·m of noise.
        assert len(errors) == (7 if phone else 3) and all(e < 0.3 for e in errors), errors
        page.on("dialog", lambda dialog: dialog.accept())
        compared(page, options, robot, log, other, name)
        if phone:
            designed(page, options)
        else:
            refusals(page, options, log)
            shipped_copy(page, options)
        if options.pictures:
            print(f"{clicking:.1f} s")


main()
