"""A newcomer's whole path: open, pick the iiwa, design, download, upload a log, read the finding, design the deciding trajectory, download the report."""

import json
import re

from browser import arguments, browser_page, check, check_contrast, picture, settle, simulate

NOISE = [0.3, 0.3, 0.2, 0.2, 0.12, 0.12, 0.06]


def design(page, options):
    page.goto(options.server)
    page.get_by_text("Nothing runs, nothing waits.").wait_for()
    check(page, "lab")
    check_contrast(page)
    page.get_by_role("link", name="Design a trajectory").click()
    page.locator("#robot option").first.wait_for(state="attached")
    page.select_option("#robot", label="KUKA LBR iiwa 14 R820 (7 joints)")
    page.fill("#order", "1")
    page.click("#go")
    # The interface refuses one harmonic, and its words stand under the field that is wrong.
    page.locator(".field:has(#order) .field-error").wait_for()
    assert page.get_attribute("#order", "aria-invalid") == "true"
    assert page.locator(".field:has(#order) .field-error").inner_text().startswith("/fourier/order is 1")
    # What the console says of the refused request is what was asked for here.
    page.trouble.clear()
    page.fill("#order", "5")
    page.fill("#time-limit", "8")
    cell(page)
    check(page, "form")
    picture(page, options, "form")
    page.click("#go")
    page.locator("#live .figure dd[data-best]").wait_for()
    # One line per start, of many points: gaps stand between them.
    page.wait_for_function("""() => { const [starts, best] = document.querySelectorAll('#live .plot');
        const lines = starts?.data?.[0]?.y ?? [];
        return lines.filter(v => v === null).length >= 2 && lines.length > 30 && best?.data?.[0]?.y.length >= 1 }""")
    picture(page, options, "search")
    page.locator("#summary").wait_for()
    settle(page)
    axes = check(page, "design")
    assert len(axes) >= 5, axes
    assert page.locator("#criteria tbody tr").count() >= 5
    assert page.locator("#coefficients math mfrac").count() == 2
    value = float(page.locator("#summary .figure:has(dt:text-is('Condition number')) dd").inner_text())
    assert 1 < value < 200, value
    picture(page, options, "design")
    page.select_option("#motion-joint", "1")
    page.get_by_role("button", name="Play").click()
    page.wait_for_timeout(400)
    page.get_by_role("button", name="Pause").click()
    assert float(page.locator("#path input[type=range]").input_value()) > 0
    page.locator("#path").scroll_into_view_if_needed()
    picture(page, options, "path", "#path")


def cell(page):
    """Limits of the cell go into the request, and what the interface says of them stands under their fields."""
    page.locator("#torque-part summary").click()
    page.check("#torque-on")
    page.fill("#torque-limits", "100, 100, 0, 50, 50, 20, 20")
    page.locator("#space-part summary").click()
    page.get_by_role("button", name="Add floor").click()
    page.check("#self-collision")
    asked = json.loads(page.locator("#as-request").text_content())["constraints"]
    assert asked["space"]["half_spaces"] == [{"name": "floor", "normal": [0, 0, 1], "offset": 0}] and asked["space"]["self_collision"] == {}, asked
    page.click("#go")
    page.locator(".field:has(#torque-limits) .field-error").wait_for()
    page.trouble.clear()
    page.uncheck("#torque-on")
    page.uncheck("#self-collision")
    page.get_by_role("button", name="Remove floor").click()
    asked = json.loads(page.locator("#as-request").text_content())["constraints"]
    assert "space" not in asked and "torque" not in asked, asked


def download(page, name):
    with page.expect_download() as waiting:
        page.locator("#downloads").get_by_role("link", name=name).click()
    target = page.folder / waiting.value.suggested_filename
    waiting.value.save_as(target)
    return target


def run_on_the_robot(page, options):
    """The robot is a virtual one, with an effect that nobody declares."""
    table = download(page, "CSV").read_text().splitlines()
    assert table[0].startswith("time,q1,") and len(table) == 10_002
    result = json.loads(download(page, "Result with request (JSON)").read_text())
    c = result["coefficients"]
    fourier = {"fundamental_hz": result["fundamental_hz"], "a": c["a"], "b": c["b"], "offset": result["offset"]}
    request = {"trajectory": {"fourier": fourier}, "periods": 4, "sample_rate_hz": 100, "noise": {"torque": NOISE}, "seed": 3,
               "effects": [{"effect": "joint_spring", "joint": "A4", "stiffness": 6.0, "rest": 0.2}]}
    log = simulate(options, "iiwa14", request, page.folder / "run.csv")
    # Played backwards: another motion over the same positions, whose log the fit does not see.
    other = {**fourier, "a": [[-v for v in row] for row in c["a"]]}
    held_out = simulate(options, "iiwa14", {**request, "trajectory": {"fourier": other}, "seed": 4}, page.folder / "other.csv")
    return log, held_out


def identify(page, options, log, held_out):
    page.get_by_role("link", name="I have run it: identify").click()
    page.locator("#excitation option").nth(1).wait_for(state="attached")
    page.set_input_files("#log", log)
    page.get_by_text("No faults found").wait_for()
    page.set_input_files("#validation", held_out)
    page.locator("#result h2", has_text="other.csv").wait_for()
    settle(page)
    check(page, "preview")
    assert "4 of 10 s" in page.locator("#result").inner_text()
    picture(page, options, "preview")
    page.click("#go")
    page.locator("#to-loop").wait_for(timeout=120_000)
    settle(page)
    check(page, "identification")
    picture(page, options, "identification", "#torques")
    page.get_by_role("button", name="Value", exact=True).click()
    assert page.locator("#parameters th[aria-sort]").inner_text().startswith("Value")
    assert page.locator("#parameters tbody math").count() > 57
    page.locator("#physical canvas").scroll_into_view_if_needed()
    picture(page, options, "bodies", "#physical")


def close_the_loop(page, options):
    page.click("#to-loop")
    page.locator("[data-effect=joint_spring]").wait_for()
    settle(page)
    check(page, "loop")
    sentence = page.locator("[data-effect=joint_spring] .sentence").inner_text()
    found = re.search(r"Joint A4 leaves [\d.]+ N·m .* a spring at the joint explains it: stiffness ([\d.]+) ± ([\d.]+) N·m/rad .* Held-out error [\d.]+ → [\d.]+ N·m", sentence)
    assert found and abs(float(found[1]) - 6.0) < 4 * float(found[2]), sentence
    picture(page, options, "loop", "#findings")
    identification = page.url
    page.click("#decide")
    page.locator("#live .figure dd[data-best]").wait_for()
    page.get_by_role("button", name="Stop and keep the best").click()
    page.locator("#summary").get_by_text("Cancelled").wait_for()
    assert "iiwa" in page.locator("#summary h2").inner_text()
    page.locator("#other option").nth(1).wait_for(state="attached")
    page.select_option("#other", index=1)
    page.locator("#compare .plot .main-svg").first.wait_for()
    check(page, "compare")
    picture(page, options, "compare", "#compare")
    page.goto(identification)


def report(page, options):
    with page.context.expect_page() as waiting:
        page.click("#report")
    sheet = waiting.value
    sheet.wait_for_load_state()
    text = sheet.inner_text("body")
    for needed in ["joint spring on A4", "a spring at the joint explains it", "SHA-256", "run.csv", "To do it again", '"seed": 1']:
        assert needed in text, needed
    # Torques of seven joints on two logs, errors, before and after, and the parameters of every unit.
    assert sheet.locator("figure svg").count() >= 14 + 4
    assert sheet.locator("math").count() > 57
    assert sheet.locator("script, link, img").count() == 0
    wide = sheet.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert wide <= 0, f"report: {wide} px wider than the screen"
    picture(sheet, options, "report")
    sheet.close()


def rest(page, options):
    page.goto(options.server + "/robot?id=iiwa14")
    page.locator("#history .plot").wait_for()
    settle(page)
    check(page, "robot")
    assert page.locator("#history .plot .errorbar").count() >= 1
    assert page.locator("#base math").count() > 57
    page.locator("#kinematics input[type=range]").nth(1).fill("0.8")
    assert "0.82 m" not in page.locator("#kinematics output.mono").inner_text()
    picture(page, options, "robot")
    page.goto(options.server)
    page.locator("#recent a").nth(2).wait_for()
    check(page, "lab")
    picture(page, options, "lab")
    # With the keyboard alone: the first stop skips to the content.
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    page.keyboard.press("Enter")
    assert page.evaluate("location.hash") == "#main"


def main():
    options = arguments()
    with browser_page(options) as page:
        design(page, options)
        log, held_out = run_on_the_robot(page, options)
        identify(page, options, log, held_out)
        close_the_loop(page, options)
        report(page, options)
        rest(page, options)


main()
