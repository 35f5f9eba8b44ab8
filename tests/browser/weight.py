"""What every page weighs on its first visit, as it is sent, and when its first content is on the screen."""

from browser import arguments, launch
from playwright.sync_api import sync_playwright

# kB as sent: pages of forms and lists, and those with 3-D views (three.js); plots are read when a result is drawn.
LIGHT, WITH_VIEWS = 130, 330
PAGES = {"/": LIGHT, "/runs": LIGHT, "/help": LIGHT, "/identification": WITH_VIEWS, "/loop": WITH_VIEWS, "/design": WITH_VIEWS, "/robot?new=1": WITH_VIEWS, "/robot?robot=iiwa14": WITH_VIEWS}
# Milliseconds, the best of three visits: what else the machine does is not the page's. One that is soon enough is the best as well as any.
LONGEST_FIRST_CONTENT = 1500
MOST_VISITS = 3


def visit(browser, address):
    """kB that were sent and milliseconds to the first content, with nothing kept."""
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    page = context.new_page()
    sent = []
    session = context.new_cdp_session(page)
    session.send("Network.enable")
    session.on("Network.loadingFinished", lambda event: sent.append(event["encodedDataLength"]))
    page.goto(address, wait_until="networkidle")
    first = page.evaluate("performance.getEntriesByName('first-contentful-paint')[0]?.startTime")
    context.close()
    return sum(sent) / 1000, first, len(sent)


def best(visits):
    return min(first for _, first, _ in visits)


def main():
    options = arguments()
    with sync_playwright() as playwright:
        browser = launch(playwright)
        for path, heaviest in PAGES.items():
            visits = [visit(browser, options.server + path)]
            while len(visits) < MOST_VISITS and best(visits) >= LONGEST_FIRST_CONTENT:
                visits.append(visit(browser, options.server + path))
            weight, first = visits[0][0], best(visits)
            if options.pictures:
                print(f"{path}: {weight:.0f} kB in {visits[0][2]} files, first content after {first:.0f} ms")
            assert 10 < weight < heaviest, f"{path}: {weight:.0f} kB"
            assert 0 < first < LONGEST_FIRST_CONTENT, f"{path}: first content after {first:.0f} ms"
        browser.close()


main()
