"""Fields that few need: sources, a part of a file, pairs that may touch, documents from files, coupled motors, filters, bounds. Each has a place, reaches the request, and is named where it is wrong."""

import csv
import json
import urllib.request
from pathlib import Path

from browser import arguments, browser_page, check, picture, settle, simulate

PANDA = Path(__file__).parent / "panda.urdf"
# N·m of the simulated log.
NOISE = [0.3, 0.2]


def fetch(options, path):
    with urllib.request.urlopen(f"{options.server}{path}") as answer:
        return json.load(answer)


def refused(page, form, text):
    """An error stands at a field and at the button; what the console says of the refused request was asked for."""
    page.locator(f"{form} .field-error", has_text=text).first.wait_for()
    page.locator(f"{form} .problem", has_text=text).first.wait_for()
    page.trouble.clear()


def refused_at(page, field, value, text):
    """What is wrong with a value stands at its field as soon as the field is left."""
    page.fill(field, value)
    page.locator(field).blur()
    page.locator("#work .field-error", has_text=text).wait_for()
    page.trouble.clear()


def open_all(page, form):
    page.evaluate("form => document.querySelectorAll(`${form} details`).forEach(part => { part.open = true; })", form)


def robot(page, options):
    page.goto(f"{options.server}/robot?new=1")
    (page.folder / "notes.urdf").write_text("my robot, as in the data sheet")
    page.set_input_files("#source-file", page.folder / "notes.urdf")
    refused(page, "#source", "is neither XML (URDF, MJCF) nor JSON")
    (page.folder / "reversed.urdf").write_text(PANDA.read_text().replace('lower="-2.8973" upper="2.8973"', 'lower="2.8973" upper="-2.8973"', 1))
    page.set_input_files("#source-file", page.folder / "reversed.urdf")
    refused(page, "#source", "the lower limit must be below the upper one")
    page.set_input_files("#source-file", PANDA)
    page.locator("#editor").wait_for()
    page.locator("#chain-part summary").click()
    page.select_option("#source-base", "panda_link1")
    page.wait_for_function("() => document.querySelectorAll('#editor details[id^=joint-]').length === 6")
    assert page.input_value("#source-base") == "panda_link1"
    page.fill("#robot-source", "CAD of the maker")
    page.locator("#joint-0 summary").click()
    page.get_by_label("panda_joint2, limits: source").fill("data sheet, page 3")
    page.get_by_label("panda_joint2, prior: source").fill("scale")
    # Angles are named as they were entered.
    page.get_by_label("panda_joint2: lowest position").fill("200")
    page.get_by_role("button", name="Save robot").click()
    refused(page, "#editor", "position (in °) is [200, 101.001]")
    page.get_by_label("panda_joint2: lowest position").fill("-100")
    page.locator(".picture canvas[data-drawn]").wait_for()
    check(page, "editor with sources")
    picture(page, options, "sources", "#joint-0")
    page.fill("#robot-id", "sourced")
    page.get_by_role("button", name="Save robot").click()
    page.locator("#kinematics canvas[data-drawn]").wait_for()
    kept = fetch(options, "/robots/sourced")
    first = kept["joints"][0]
    assert [kept["source"], first["limits"]["source"], first["prior"]["source"]] == ["CAD of the maker", "data sheet, page 3", "scale"], kept
    assert len(kept["joints"]) == 6 and "source" not in first and "source" not in kept["joints"][1]["limits"]


def asked(page):
    return json.loads(page.locator("#as-request").text_content())


def finished(page):
    before = page.url
    page.click("#go")
    page.wait_for_url(lambda url: url != before and "id=" in url)
    page.locator("#clearances").wait_for(state="detached")
    page.locator("#clearances").wait_for()
    return page.url.split("id=")[1]


def design(page, options):
    page.goto(f"{options.server}/design?robot=iiwa14")
    page.wait_for_function("() => document.querySelector('#as-request')?.textContent.includes('half_spaces')")
    open_all(page, "#form")
    page.click("#touch-add")
    page.select_option("#touch-0-0", "A2")
    page.select_option("#touch-0-1", "A6")
    assert asked(page)["constraints"]["space"]["self_collision"] == {"ignore": [["A2", "A6"]]}
    # Neighbours are not compared: there is no pair of them.
    assert "A3" not in page.locator("#touch-0-1").inner_text()
    page.fill("#search-starts", "0")
    page.click("#go")
    refused(page, "#form", "Random starts is 0")
    page.fill("#search-starts", "4")
    page.fill("#search-evaluations", "3000")
    page.fill("#time-limit", "2")
    page.click("#own-effects-add")
    check(page, "every field of a design")
    picture(page, options, "every-field-design", "#touching")
    first = finished(page)
    request = fetch(options, f"/excitation/{first}")["request"]
    assert request["constraints"]["space"]["self_collision"]["ignore"] == [["A2", "A6"]] and request["search"]["starts"] == 4 and request["effects"][0]["name"] == "counterbalance", request
    # A pair that came near, from the table of clearances.
    page.get_by_role("button", name="touch in the next design").first.click()
    assert len(asked(page)["constraints"]["space"]["self_collision"]["ignore"]) == 2
    from_files(page, options, first)
    # A floor in the way is named at the floor and at the button.
    page.locator("#obstacle-0-offset").fill("0.5")
    page.click("#go")
    page.locator("#obstacles .field-error", has_text="into “floor”").wait_for()
    page.locator("#form-trouble .problem", has_text="into “floor”").wait_for()
    check(page, "a floor in the way")


def from_files(page, options, first):
    """A design and data of another server."""
    (page.folder / "design.json").write_text(json.dumps(fetch(options, f"/excitation/{first}")))
    open_all(page, "#form")
    page.set_input_files("#model-file", page.folder / "notes.urdf")
    page.locator("#files-part .file-error", has_text="is no JSON file").wait_for()
    page.set_input_files("#model-file", [])
    page.set_input_files("#warm-start-file", page.folder / "design.json")
    page.set_input_files("#given-files", page.folder / "design.json")
    page.wait_for_function("() => document.querySelector('#as-request').textContent.includes('warm_start')")
    request = asked(page)
    assert "identification" not in request["given"][0] and request["given"][0]["fundamental_hz"] == 0.1 and "model" not in request, request
    second = finished(page)
    assert second != first and len(fetch(options, f"/excitation/{second}")["request"]["given"]) == 1


def coupled_log(options, folder):
    """Both motors of a small arm are in its base: the second one turns with both joints. And the same log by joints."""
    series = {"fourier": {"fundamental_hz": 0.2, "a": [[0.4, -0.2], [0.3, 0.3]], "b": [[0.1, 0.2], [-0.2, 0.1]]}}
    plain = simulate(options, "planar_two_link", {"trajectory": series, "periods": 4, "sample_rate_hz": 100, "noise": {"torque": NOISE}, "seed": 2}, folder / "joints.csv")
    with plain.open() as source, (folder / "motors.csv").open("w") as out:
        out.write("time,motor_position_1,motor_position_2,motor_torque_1,motor_torque_2\n")
        for row in csv.DictReader(source):
            q1, q2, tau1, tau2 = (float(row[key]) for key in ["q1", "q2", "tau1", "tau2"])
            out.write(f"{row['time']},{-q1:.8f},{q1 + q2:.8f},{tau1 - tau2:.6f},{tau2:.6f}\n")
    return folder / "motors.csv", plain


def identification(page, options):
    log, plain = coupled_log(options, page.folder)
    page.goto(f"{options.server}/identification?robot=planar_two_link")
    page.locator("#robot option").first.wait_for(state="attached")
    page.click("#go")
    refused(page, "#form", "The log is missing")
    page.set_input_files("#log", log)
    page.locator("#result h2", has_text=log.name).wait_for()
    open_all(page, "#work")
    # The first motor counts backwards.
    page.get_by_label("motor_position_1: sign").select_option("-1")
    refused_at(page, "#columns-coupling", "1 0", "Coupling of the motors")
    page.fill("#columns-coupling", "1 0; 1 1")
    page.fill("#columns-torque-offset", "0, 0")
    refused_at(page, "#position-filter-cutoff", "20", "Order of the position filter is missing")
    page.fill("#position-filter-cutoff", "")
    refused_at(page, "#link-bounds", '[{"link": 1, "mass": [2, 1]}]', "the lower bound must not be above the upper one")
    page.fill("#link-bounds", '[{"link": 1, "mass": [0.1, 90]}]')
    page.locator("#link-bounds").blur()
    page.locator("#result h2", has_text=log.name).wait_for()
    settle(page)
    check(page, "every field of an identification")
    picture(page, options, "every-field-identification", "#transmissions")
    page.click("#go")
    page.locator("#check").wait_for(timeout=120_000)
    result = fetch(options, f"/identify/{page.url.split('id=')[1]}?predictions=false")
    columns = result["provenance"]["request"]["columns"]
    assert columns["coupling"] == [[1, 0], [1, 1]] and columns["position"]["sign"] == [-1, 1] and columns["torque"]["offset"] == [0, 0], columns
    errors = result["rms"]["identification"][0]["base"]["rms"]
    assert all(e < 1.2 * n for e, n in zip(errors, NOISE)), errors
    checked(page, options, plain)


def checked(page, options, plain):
    """The model of the motors' log, held against the same motion in columns of other names."""
    odd = page.folder / "odd.csv"
    odd.write_text(plain.read_text().replace("q1", "shoulder", 1).replace("q2", "elbow", 1))
    page.set_input_files("#check-log", odd)
    page.locator("#check #columns .notice", has_text="no position for any joint").wait_for()
    for header, at in [("shoulder", 0), ("elbow", 1)]:
        page.locator("#check").get_by_label(f"{header}: used as").select_option(f"position {at}")
    page.locator("#check summary").first.click()
    page.fill("#check-period", "-1")
    check(page, "columns of a check")
    page.get_by_role("button", name="Check the model").click()
    refused(page, "#check", "Period is -1")
    page.fill("#check-period", "5")
    page.get_by_role("button", name="Check the model").click()
    page.wait_for_url("**/identification?validation=*")
    page.locator("#errors").wait_for()
    errors = fetch(options, f"/validate/{page.url.split('validation=')[1]}")["logs"][0]["rms"]
    assert errors, errors


def main():
    options = arguments()
    with browser_page(options) as page:
        robot(page, options)
        design(page, options)
        identification(page, options)


main()
