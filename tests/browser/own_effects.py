"""Effects of one's own on the pages: a column of the log as a further quantity, a formula with it, kept in the lab's catalogue, used from there, and removed."""

import csv
import json
import math
import urllib.request

from browser import arguments, browser_page, check, check_in_reach, picture, settle, simulate

# Torque per kelvin on the second joint, and the temperature without it.
PER_KELVIN, COLD = 0.05, 22.0
ROBOT = "planar_two_link"


def standard():
    links = [[3.0, 0.6, 0.03, 0.0, 0.02, 0.0, 0.0, 0.2, 0.0, 0.2], [1.0, 0.2, -0.01, 0.0, 0.01, 0.0, 0.0, 0.06, 0.0, 0.06]]
    return links[0] + [0.3, 0.5] + links[1] + [0.1, 0.2]


def warm_log(options, folder):
    """Four periods, in each of which a gear warms up and cools down, with its temperature in a column of the controller's name."""
    request = {"parameters": standard(), "trajectory": {"fourier": {"fundamental_hz": 0.2, "a": [[0.5, -0.3, 0.2], [0.2, 0.4, -0.6]], "b": [[0.1, 0.4, -0.3], [-0.4, 0.2, 0.3]]}},
               "periods": 4, "sample_rate_hz": 100, "noise": {"torque": [0.01, 0.01]}, "seed": 3}
    plain = simulate(options, ROBOT, request, folder / "plain.csv")
    with plain.open() as source, (folder / "warm.csv").open("w") as out:
        rows = csv.DictReader(source)
        names = ["time", "q1", "q2", "tau1", "tau2"]
        out.write(",".join([*names, "T_gear2"]) + "\n")
        for row in rows:
            temperature = COLD + 12 * math.sin(math.pi * float(row["time"]) / 5) ** 2
            row["tau2"] = float(row["tau2"]) + PER_KELVIN * (temperature - COLD)
            out.write(",".join(str(row[n]) for n in names) + f",{temperature:.3f}\n")
    return folder / "warm.csv"


def kept(options):
    with urllib.request.urlopen(f"{options.server}/effects") as answer:
        return json.load(answer)["effects"]


def map_quantity(page, options, log):
    page.goto(f"{options.server}/identification?robot={ROBOT}")
    page.locator("#robot option").first.wait_for(state="attached")
    page.set_input_files("#log", log)
    page.locator("#columns").wait_for()
    page.locator("#columns summary").first.click()
    page.locator("#columns tr", has_text="T_gear2").locator("select").select_option("channel")
    name, unit = page.get_by_label("T_gear2: name in formulas"), page.get_by_label("T_gear2: unit")
    # Its header says what it is.
    assert (name.input_value(), unit.input_value()) == ("T_gear2", "degC")
    name.fill("2nd gear")
    name.blur()
    page.locator("#columns .field-error", has_text="is no name in an expression").wait_for()
    said = page.locator("#columns .field-error").inner_text()
    assert said == "T_gear2: name in formulas is no name in an expression. Use letters, digits and “_”, such as “temperature”.", said
    page.trouble.clear()
    picture(page, options, "quantity-refused", "#columns")
    page.get_by_label("T_gear2: name in formulas").fill("temperature")
    page.get_by_label("T_gear2: name in formulas").blur()
    page.locator("#columns td", has_text="temperature (degC)").wait_for()
    page.wait_for_function("() => !document.querySelector('.field-error')")
    settle(page)
    check(page, "quantity")
    picture(page, options, "quantity", "#columns")


def write_effect(page, options):
    page.locator("#own-effects > summary").click()
    assert page.locator("#own-effects-choose").is_hidden(), "an empty catalogue is no choice"
    page.get_by_role("button", name="Write an effect").click()
    field = lambda pointer: page.locator(f"#own-effects [data-pointer='/effects/0/{pointer}']")
    # The example is set as a formula at once.
    page.locator("#own-effects .formula math msqrt").wait_for()
    picture(page, options, "effect-example", "#own-effects")
    field("name").fill("warm")
    field("joint").select_option("J2")
    for _ in range(2):
        page.get_by_role("button", name="Remove rho").or_(page.get_by_role("button", name="Remove q0")).first.click()
    field("parameters/0/name").fill("c")
    field("parameters/0/unit").fill("N m/K")
    # What was removed is missed by the formula.
    page.locator("#own-effects .formula", has_text="is neither").wait_for()
    page.trouble.clear()
    # Half a formula is not asked for: nothing in the console says that it was refused.
    for half, said in [("", "No formula yet."), ("c*(temp", "A parenthesis is still open."), ("c *", "The formula is not complete yet.")]:
        field("expression").fill(half)
        page.locator("#own-effects .formula", has_text=said).wait_for()
    assert not page.trouble, page.trouble
    field("expression").fill("c*(temperature - 22)")
    page.locator("#own-effects .formula", has_text="“temperature” is neither a variable nor a parameter").wait_for()
    page.trouble.clear()
    page.get_by_role("button", name="Save to the lab").click()
    page.locator("#own-effects .field-error", has_text="“temperature” is neither").wait_for()
    said = page.locator("#own-effects .field-error").inner_text()
    assert said.startswith("Torque of own effect 1: “temperature” is neither a variable nor a parameter. Variables are "), said
    page.trouble.clear()
    picture(page, options, "effect-refused", "#own-effects")
    page.get_by_role("button", name="Add a quantity").click()
    field("channels/0/name").fill("temperature")
    field("channels/0/unit").fill("degC")
    field("channels/0/reference").fill("22")
    field("declared").select_option("yes")
    page.locator("#own-effects .formula math", has_text="temperature").wait_for()
    page.trouble.clear()
    page.get_by_role("button", name="Save to the lab").click()
    page.get_by_text("Saved to the lab.").wait_for()
    assert page.get_by_role("button", name="Replace warm in the lab").is_visible()
    check(page, "effect")
    picture(page, options, "effect", "#own-effects")
    [entry] = kept(options)
    assert entry["definition"]["channels"] == [{"name": "temperature", "unit": "degC", "reference": 22.0}] and entry["definition"]["declared"], entry


def identify(page, options, effects):
    page.get_by_role("button", name="Identify", exact=True).click()
    page.locator("#effects").or_(page.locator("#result section").nth(1)).first.wait_for()
    page.wait_for_url("**/identification?id=*")
    page.locator("#result h2").first.wait_for()
    page.wait_for_function("() => document.querySelector('#live').hidden")
    with urllib.request.urlopen(f"{options.server}/identify/{page.url.split('id=')[1]}") as answer:
        result = json.load(answer)
    found = [(e["effect"], e["joints"]) for e in result["effects"] if e["declared"]]
    assert found == effects, result["effects"]
    value = next(p for p in result["effects"][0]["parameters"] if p["name"] == "c")
    assert abs(value["value"] - PER_KELVIN) < 4 * value["std_dev"] < 0.01, value
    asked = result["provenance"]["request"]
    assert asked["columns"]["channels"] == [{"name": "temperature", "header": "T_gear2", "unit": "degC"}], asked["columns"]
    assert asked["effects"][0]["expression"] == "c*(temperature - 22)", asked["effects"]


def use(page, options, log):
    page.goto(f"{options.server}/identification?robot={ROBOT}")
    page.locator("#robot option").first.wait_for(state="attached")
    page.locator("#own-effects > summary").click()
    page.locator("#own-effects-choose option", has_text="warm").wait_for(state="attached")
    for _ in range(3):
        page.select_option("#own-effects-choose", "warm")
    legends = page.locator("#own-effects legend")
    assert legends.all_inner_texts() == [f"Own effect {k}: warm of the lab" for k in (1, 2, 3)]
    # Each has a name of its own; the joint is that of the catalogue.
    assert page.input_value("#own-1-name") == "warm_2" and page.input_value("#own-1-joint") == "J2"
    check(page, "used")
    picture(page, options, "effects-used", "#own-effects")
    page.get_by_role("button", name="Remove the effect").nth(1).click()
    # A copy may be written anew without a change of the catalogue.
    page.get_by_role("button", name="Edit a copy").nth(1).click()
    assert page.input_value("#own-1-expression") == "c*(temperature - 22)" and page.input_value("[data-pointer='/effects/1/channels/0/reference']") == "22"
    page.get_by_role("button", name="Remove the effect").nth(1).click()
    page.set_input_files("#log", log)
    page.locator("#columns").wait_for()
    # The table of columns remembers the quantity.
    page.locator("#columns td", has_text="temperature (degC)").wait_for()
    identify(page, options, [("warm", ["J2"])])


def of_robot(page, options):
    """A robot has an effect of the catalogue, which stays as it was named, and one that is written in its editor."""
    page.goto(f"{options.server}/robot?robot={ROBOT}")
    page.get_by_role("button", name="Edit a copy").click()
    page.locator("#own-effects > summary").click()
    page.select_option("#own-effects-choose", "warm")
    page.get_by_role("button", name="Write an effect").click()
    field = lambda pointer: page.locator(f"#own-effects [data-pointer='/robot/effects/1/{pointer}']")
    field("joint").select_option("J2")
    field("expression").fill("b*sin(q - q0)/sqrt(1 - rho*cos(q - q9))")
    page.get_by_role("button", name="Save robot").click()
    # At the field, and at the button.
    page.locator("#own-effects .field-error", has_text="“q9” is neither").wait_for()
    page.locator("#editor [role=alert]", has_text="The description has 1 problem").wait_for()
    page.trouble.clear()
    field("expression").fill("b*sin(q - q0)/sqrt(1 - rho*cos(q - q0))")
    page.wait_for_function("() => !document.querySelector('.field-error')")
    check_in_reach(page, "#editor > .actions .primary")
    check(page, "robot's effects")
    picture(page, options, "robot-effects", "#own-effects")
    page.fill("#robot-id", "warm-arm")
    page.get_by_role("button", name="Save robot").click()
    page.locator("#own math").nth(1).wait_for()
    assert page.locator("#own tbody tr").count() == 2
    check(page, "robot with effects")
    effects = robot(options)["effects"]
    assert effects[0]["use"] == "warm" and effects[0]["joint"] == "J2" and effects[1]["name"] == "counterbalance", effects
    rename(page, options, effects)


def rename(page, options, effects):
    """Edits elsewhere leave the effects as they are; a joint of another name is an error at the effect that acts on it."""
    page.get_by_role("button", name="Edit", exact=True).click()
    page.fill("[data-pointer='/robot/joints/1/name']", "elbow")
    page.locator("#own-effects .field-error", has_text="no joint “J2”").nth(1).wait_for()
    page.trouble.clear()
    page.fill("[data-pointer='/robot/joints/1/name']", "J2")
    page.wait_for_function("() => !document.querySelector('.field-error')")
    page.fill("#robot-name", "Warm arm")
    page.get_by_role("button", name="Save robot").click()
    page.locator("#own math").nth(1).wait_for()
    assert robot(options)["effects"] == effects
    page.once("dialog", lambda dialog: dialog.accept())
    page.get_by_role("button", name="Delete", exact=True).click()
    page.locator("#recent").wait_for()


def robot(options):
    with urllib.request.urlopen(f"{options.server}/robots/warm-arm") as answer:
        return json.load(answer)


def remove(page, options):
    page.goto(options.server)
    row = page.locator("#effects tr", has_text="warm")
    row.wait_for()
    assert row.locator("math").count() == 1
    check(page, "lab")
    picture(page, options, "lab-effects", "#effects-part")
    page.once("dialog", lambda dialog: dialog.accept())
    page.get_by_role("button", name="Delete warm").click()
    page.locator("#effects-part").wait_for(state="hidden")
    assert kept(options) == []


def main():
    options = arguments()
    with browser_page(options) as page:
        log = warm_log(options, page.folder)
        map_quantity(page, options, log)
        write_effect(page, options)
        identify(page, options, [("warm", ["J2"])])
        use(page, options, log)
        of_robot(page, options)
        remove(page, options)


if __name__ == "__main__":
    main()
