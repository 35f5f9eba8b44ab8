"""Debian's Chromium, with what every page must keep to."""

import argparse
import contextlib
import json
import re
import subprocess
import tempfile
from pathlib import Path
from urllib.parse import urlsplit

from playwright.sync_api import sync_playwright

from accessible import check_accessible
from watch import watch

# --no-sandbox: containers run as root. No GPU: the same pictures everywhere. Containers have little shared memory.
FLAGS = ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"]
# Milliseconds that Playwright waits for one thing, and seconds that a program may take.
LONGEST_WAIT = 120_000
LONGEST_RUN_S = 120


def arguments():
    """The options of a script, which is watched from here on."""
    watch()
    parser = argparse.ArgumentParser()
    parser.add_argument("--server", required=True)
    parser.add_argument("--program", required=True)
    parser.add_argument("--width", type=int, default=1366)
    parser.add_argument("--height", type=int, default=768)
    parser.add_argument("--pictures", type=Path, help="folder to put pictures of the pages into")
    parser.add_argument("--assets", type=Path, help="folder of pages to take in place of those in the program, to see changes without building it")
    return parser.parse_args()


def launch(playwright, *flags):
    return playwright.chromium.launch(executable_path="/usr/bin/chromium", args=[*FLAGS, *flags])


@contextlib.contextmanager
def browser_page(options):
    """A page that fails on errors of scripts and on anything it asks of another server."""
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        browser = launch(playwright)
        phone = options.width < 500
        # A phone in the dark theme, a laptop in the light one.
        context = browser.new_context(viewport={"width": options.width, "height": options.height}, is_mobile=phone, has_touch=phone, accept_downloads=True, color_scheme="dark" if phone else "light",
                                      reduced_motion="reduce")
        if options.assets:
            context.route(f"{options.server}/**", lambda route: from_disk(route, options))
        context.set_default_timeout(LONGEST_WAIT)
        page = context.new_page()
        page.trouble = []
        page.folder = Path(folder)
        page.on("pageerror", lambda e: page.trouble.append(f"script: {e}"))
        page.on("console", lambda m: page.trouble.append(f"console: {m.text}") if m.type == "error" else None)
        context.on("request", lambda r: page.trouble.append(f"outside: {r.url}") if not r.url.startswith((options.server, "blob:", "data:")) else None)
        yield page
        browser.close()
        assert not page.trouble, page.trouble


def from_disk(route, options):
    """Answers with a file of the folder, or with a page put together as the server does; all else, and all headers, are the server's."""
    path = urlsplit(route.request.url).path
    name = path.removeprefix("/assets/") if path.startswith("/assets/") else f"{path.strip('/') or 'lab'}.html"
    file = options.assets / name
    if route.request.method != "GET" or not file.is_file():
        return route.continue_()
    if path.startswith("/assets/"):
        return route.fulfill(path=file)
    title, name = "Diagnosis" if name == "loop.html" else file.stem.capitalize(), file.stem
    frame = (options.assets / "frame.html").read_text()
    answer = route.fetch()
    return route.fulfill(response=answer, body=frame.replace("{title}", title).replace("{name}", name).replace("{main}", file.read_text()))


def settle(page):
    """Every plot of the page is scrolled to and drawn."""
    page.evaluate("""async (longest) => {
        const frame = () => new Promise((done, failed) => {
            const late = setTimeout(() => failed(new Error(`no frame within ${longest} ms`)), longest);
            requestAnimationFrame(() => { clearTimeout(late); done(); }); });
        const open = () => [...document.querySelectorAll('.plot')].filter(p => p.clientWidth > 0 && p.closest('[hidden]') === null && !p.querySelector('.main-svg'));
        // Two frames, so that what observes the window has seen this part; again where plots came in meanwhile.
        for (const begun = performance.now(); open().length;) {
            for (const plot of open()) { plot.scrollIntoView({behavior: 'instant', block: 'center'}); await frame(); await frame(); }
            if (performance.now() - begun > longest) throw new Error(`not drawn: ${open().map(p => p.dataset.label)}`);
        }
        window.scrollTo(0, 0); }""", 60_000)


def check(page, name):
    """What every page must keep to: nothing wider than the screen, labels on all controls, names given once, units on all axes."""
    page.wait_for_timeout(150)
    wide = page.evaluate("""() => { const width = document.documentElement.clientWidth;
        return document.documentElement.scrollWidth > width ? [...document.querySelectorAll('main *')].filter(e => e.getBoundingClientRect().right > width + 1 && !e.closest('.scroll, .toc, nav, pre')).map(e => e.outerHTML.slice(0, 120)).slice(0, 5).concat('page') : [] }""")
    assert not wide, f"{name}: wider than the screen: {wide}"
    unnamed = page.evaluate("""() => [...document.querySelectorAll('input, select, textarea, button, canvas, img, a')].filter(e => e.closest('.modebar') === null).filter(e => {
        const named = e.getAttribute('aria-label') || e.getAttribute('aria-labelledby') || (e.labels && e.labels.length && e.labels[0].textContent.trim());
        return !(named || (e.tagName === 'IMG' && e.hasAttribute('alt')) || (['BUTTON', 'A'].includes(e.tagName) && e.textContent.trim())) }).map(e => e.outerHTML.slice(0, 120))""")
    assert not unnamed, f"{name}: controls without a name: {unnamed}"
    twice = page.evaluate("""() => { const ids = [...document.querySelectorAll('[id]')].filter(e => !e.closest('.js-plotly-plot')).map(e => e.id);
        return ids.filter((id, i) => ids.indexOf(id) !== i) }""")
    assert not twice, f"{name}: ids given twice: {twice}"
    axes = page.evaluate("""() => [...document.querySelectorAll('.plot')].filter(p => p.clientWidth > 0 && p.querySelector('.main-svg')).map(p =>
        [p.dataset.label, [...p.querySelectorAll('.infolayer text')].filter(t => /^[xy]\\d*title/.test(t.getAttribute('class') ?? '')).map(t => t.textContent)])""")
    # Every term has its explanation, and no explanation is for the mouse alone.
    unknown = page.evaluate("""async () => { const files = ['/assets/glossary.json', '/assets/effects.json'];
        const topics = (await Promise.all(files.map(async file => (await fetch(file)).json()))).flat();
        const known = new Set(topics.flatMap(topic => Object.keys(topic.terms)));
        return [...document.querySelectorAll('[data-term]')].map(e => e.dataset.term).filter(key => !known.has(key)).concat([...document.querySelectorAll('main th[title]')].map(e => e.title)) }""")
    assert not unknown, f"{name}: terms without an explanation: {unknown}"
    check_helped(page, name)
    check_heads(page, name)
    check_accessible(page, name)
    for label, titles in axes:
        assert label, f"{name}: a plot without a label for those who do not see it"
        assert len(titles) >= 2, f"{name}: {label}: axes without titles: {titles}"
        for title in titles:
            counted = re.search(r"joint|parameter|link|start, best|evaluations|identification|criterion|condition number|margin|ratio|^data$", title)
            assert counted or re.search(r"\(.+\)", title), f"{name}: {label}: no unit in `{title}`"
    return axes


# Drop-downs whose entries are names of the user's own things, or units.
PLAIN = {"Robot", "Log", "Joint", "Parameter", "Unit", "Identification", "With", "Angles in", "Over", "and", "Trajectory"}


def check_helped(page, name):
    """Every drop-down has help: on a term beside it, in a line under it, or in the head of its column."""
    found = page.evaluate("""() => [...document.querySelectorAll('main select')].filter(e => e.offsetParent).map(e => {
        const label = (e.labels[0]?.firstChild?.textContent ?? e.getAttribute('aria-label') ?? '').trim();
        const part = e.closest('.field, .stacked, fieldset, tr, .row') ?? e.parentElement;
        const table = e.closest('table');
        return [label, Boolean(part.querySelector('[data-term], .help') ?? table?.querySelector('th [data-term]') ?? part.parentElement.querySelector('.labelled [data-term]'))]; })""")
    bare = [label for label, helped in found if not helped and label not in PLAIN]
    assert not bare, f"{name}: drop-downs without help: {bare}"


# Heads of tables that need no help, without their units.
PLAIN_HEADS = {"Joint", "Joints", "Robot", "Log", "Logs", "Run", "Name", "Unit", "File", "Bytes", "Link", "Parameter", "Value", "Value so far", "Sum", "At", "On", "With", "From", "Link of", "Step", "Choice", "Reason",
               "Column", "Series", "First values", "Data", "Limit", "Allowed", "Reached", "Required", "Position", "Positions", "Velocity", "Acceleration", "Torque", "Torques", "Top speed", "Prior mass",
               "Mass", "Centre of mass x", "Centre of mass y", "Centre of mass z", "x", "y", "z", "from", "to", "velocity", "acceleration", "torque", "Criterion", "Meaning", "Choose it when", "Limitation",
               "Design", "This one", "The other", "With the effects", "Evidence", "Started", "Ended", "Identification"}


def check_heads(page, name):
    """Every head of a column has help, or is a plain word or a name that the user gave."""
    bare = page.evaluate("""() => [...document.querySelectorAll('main th[scope=col]')].filter(e => !e.querySelector('[data-term], .unseen') && e.dataset.own === undefined).map(e => e.textContent.trim().replace(/ \\(.*\\)$/, ''))""")
    unknown = sorted({head for head in bare if head not in PLAIN_HEADS})
    assert not unknown, f"{name}: heads without help: {unknown}"


# Points of a printed page: its lower margin of 18 mm, and a heading with two lines below it.
LOWER_MARGIN = 51
HEADING_AND_TEXT = 45


def check_prints(page, name):
    """The PDF file of a page: no heading stands alone at the foot of a sheet. Hands back the number of sheets."""
    printed = page.pdf(prefer_css_page_size=True, outline=True, tagged=True)
    headings = [float(y) for y in re.findall(rb"/Dest\s*\[\d+ 0 R /XYZ [\d.]+ ([\d.]+)", printed)]
    assert len(headings) >= page.locator("h1, h2").count(), f"{name}: {len(headings)} headings in the outline"
    stranded = [y for y in headings if y < LOWER_MARGIN + HEADING_AND_TEXT]
    assert not stranded, f"{name}: headings at the foot of a sheet: {stranded}"
    return len(re.findall(rb"/Type\s*/Page\b", printed))


def check_in_reach(page, button):
    """The button of a form is on the screen, and not below anything, wherever the page is scrolled to."""
    for share in [0, 0.5, 1]:
        reached = page.locator(button).evaluate("""(button, share) => { const all = document.documentElement;
            window.scrollTo({top: share * (all.scrollHeight - innerHeight), behavior: 'instant'});
            const at = button.getBoundingClientRect();
            return document.elementFromPoint(at.x + at.width / 2, at.y + at.height / 2) === button; }""", share)
        assert reached, f"{button}: out of reach at {share} of the page"
    page.evaluate("window.scrollTo(0, 0)")


def check_error(page, at, summary, said, field):
    """An error in the same words at its field and in the summary, where the name of the field leads to it; no pointer of a document stands in either."""
    lines = page.locator(f"{summary} li")
    shown = [" ".join(text.split()) for text in lines.all_inner_texts()]
    assert page.locator(at).inner_text() == said and said in shown, (page.locator(at).inner_text(), shown)
    page.evaluate("document.activeElement.blur()")
    lines.nth(shown.index(said)).get_by_role("button").click()
    assert page.locator(field).evaluate("field => field === document.activeElement"), f"{field}: not reached from the summary"


def picture(page, options, name, at=None):
    """What is on the screen, or would be with the part `at` at its top."""
    if options.pictures:
        if at:
            page.locator(at).evaluate("part => part.scrollIntoView({behavior: 'instant'})")
            page.wait_for_timeout(300)
        options.pictures.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=options.pictures / f"{name}-{options.width}.png")


def simulate(options, robot, request, out):
    """A log of a virtual robot."""
    document = out.with_suffix(".request.json")
    document.write_text(json.dumps(request))
    subprocess.run([options.program, "simulate", "--robot", robot, "--request", str(document), "--out", str(out)], check=True, capture_output=True, timeout=LONGEST_RUN_S)
    return out
