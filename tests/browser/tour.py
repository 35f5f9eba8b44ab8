"""From an empty server to a closed loop with one click, and the tour from there to one's own robot."""

import time

from browser import arguments, browser_page, check, picture, settle

# The demo is there to be waited for: on a busy machine of two cores.
LONGEST_S = 60


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
        settle(page)
        check(page, "tour")
        picture(page, options, "tour")
        for step, place in [(2, "#parameters"), (3, "#form"), (4, "#source")]:
            page.locator("#tour a").click()
            page.wait_for_url(f"**tour={step}**")
            page.locator("#tour").get_by_text(f"Tour {step} of 4").wait_for()
            page.locator(place).wait_for()
        page.locator("#tour a").click()
        # Once there is something else to see, the demo steps back; its run has a name.
        page.locator("#recent").get_by_role("link", name="Demo: iiwa 14 with a hidden spring").wait_for()
        assert page.get_by_role("heading", name="New here?").count() == 0
        check(page, "lab after the demo")
        page.goto(f"{options.server}/help#diagnosis")
        assert page.locator("#diagnosis math").count() == 1
        check(page, "help")
        picture(page, options, "help")


main()
