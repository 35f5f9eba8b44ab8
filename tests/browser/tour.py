"""From an empty server to a closed loop with one click, and the tour from there to one's own robot."""

import re
import time

from accessible import check_accessible, violations
from browser import arguments, browser_page, check, picture, settle

# The demo is there to be waited for: on a busy machine of two cores.
LONGEST_S = 60


def terms(page, options):
    """Help on a term by mouse, touch and keyboard: it opens, stays within the window, leads to the help, and closes."""
    page.goto(f"{options.server}/loop")
    term = page.locator("#summary [data-term=noise_floor]")
    term.wait_for()
    help_ = page.locator("#term-help")
    phone = options.width < 500
    if phone:
        term.tap()
    else:
        term.hover()
    help_.get_by_text("RMS error that noise alone causes").wait_for()
    box = help_.bounding_box()
    assert box["x"] >= 0 and box["x"] + box["width"] <= options.width and box["y"] >= 0 and box["y"] + box["height"] <= options.height, box
    picture(page, options, "term")
    if phone:
        # The margin of the page: headings are terms themselves.
        page.touchscreen.tap(1, 300)
    else:
        page.mouse.move(1, 1)
    help_.wait_for(state="detached")
    term.focus()
    page.keyboard.press("Enter")
    help_.wait_for()
    assert term.get_attribute("aria-expanded") == "true" and term.get_attribute("aria-describedby") == "term-help"
    check_accessible(page, "term")
    page.keyboard.press("Escape")
    help_.wait_for(state="detached")
    page.keyboard.press("Enter")
    help_.wait_for()
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.getAttribute('href')") == "/help#diagnosis"
    page.keyboard.press("Enter")
    page.wait_for_url("**/help#diagnosis")


def docs(page, options):
    """The interface at /docs/: Swagger UI, with what it leaves out for those who do not see it."""
    page.goto(f"{options.server}/docs/")
    page.locator("h3[aria-level='2']").first.wait_for()
    found = violations(page)
    assert not found, f"docs: {found}"
    page.get_by_role("button", name="Design an excitation trajectory.").click()
    page.get_by_role("button", name="Try it out").click()
    page.get_by_role("button", name="Execute").wait_for()
    found = violations(page)
    assert not found, f"docs, opened: {found}"
    wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert wide <= 0, f"docs: {wide} px wider than the screen"
    picture(page, options, "docs")


def turned(page, options):
    """Plots of a phone that is turned, or of a narrow window, are as high as what they draw, and nothing is below them."""
    grown = """() => [...document.querySelectorAll('.plot .svg-container')].filter(c => c.offsetHeight > c.closest('.plot').offsetHeight + 1).map(c => c.closest('.plot').dataset.label)"""
    for width, height in [(844, 390), (390, 844), (options.width, options.height)]:
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(300)
        settle(page)
        assert not page.evaluate(grown), (width, page.evaluate(grown))


def parts(page):
    """A link to a part of the result scrolls, and the page stays what it is."""
    page.locator("#errors").wait_for()
    page.evaluate("window.same = true")
    page.get_by_role("navigation", name="Parts of the result").get_by_role("link", name="Errors").click()
    page.wait_for_timeout(500)
    assert page.evaluate("window.same") and page.url.endswith("#errors"), page.url


def main():
    options = arguments()
    with browser_page(options) as page:
        page.goto(options.server)
        page.get_by_role("heading", name="New here?").wait_for()
        check(page, "empty")
        picture(page, options, "empty")
        begun = time.monotonic()
        page.click("#demo")
        page.wait_for_url("**/loop?id=*", timeout=LONGEST_S * 1000)
        page.locator(".finding[data-effect=joint_spring]").wait_for()
        taken = time.monotonic() - begun
        assert taken < LONGEST_S, taken
        assert "A4" in page.locator(".finding[data-effect=joint_spring]").first.inner_text()
        # The error on the second log is that of the noise.
        after, noise = map(float, re.search(r"→ ([\d.]+) N·m \(noise alone ([\d.]+)\)", page.locator(".finding .sentence").first.inner_text()).groups())
        assert 0.8 < after / noise < 1.2, (after, noise)
        settle(page)
        check(page, "tour")
        turned(page, options)
        picture(page, options, "tour")
        for step, place in [(2, "#parameters"), (3, "#form"), (4, "#source")]:
            page.locator("#tour a").click()
            page.wait_for_url(f"**tour={step}**")
            page.locator("#tour").get_by_text(f"Tour {step} of 4").wait_for()
            page.locator(place).wait_for()
            if step == 2:
                parts(page)
        page.locator("#tour a").click()
        # Once there is something else to see, the demo steps back; its run has a name.
        page.locator("#recent").get_by_role("link", name="Demo: iiwa 14 with a hidden spring").wait_for()
        assert page.get_by_role("heading", name="New here?").count() == 0
        check(page, "lab after the demo")
        page.goto(f"{options.server}/help#diagnosis")
        assert page.locator("#diagnosis math").count() == 1
        page.locator("#term-noise_floor").wait_for()
        check(page, "help")
        picture(page, options, "help")
        terms(page, options)
        docs(page, options)


main()
