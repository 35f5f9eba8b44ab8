"""What axe-core finds on a page, and contrast in both themes."""

from axe_playwright_python.sync_playwright import Axe

AXE = Axe().axe_script
RULES = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"], "resultTypes": ["violations"]}
CONTRAST = {"runOnly": {"type": "rule", "values": ["color-contrast"]}, "resultTypes": ["violations"]}
# Of text on its ground in both themes (WCAG 2, level AA).
LEAST_CONTRAST = 4.5
PAIRS = [("--ink", "--ground"), ("--ink", "--card"), ("--soft", "--card"), ("--soft", "--ground"), ("--soft", "--sunk"), ("--accent", "--card"),
         ("--accent", "--accent-soft"), ("--on-accent", "--accent"), ("--good", "--good-soft"), ("--warn", "--warn-soft"), ("--bad", "--bad-soft"), ("--ink", "--bad-soft")]

# Contrast is most of what axe-core computes, and hundreds of cells look alike. Parts with text get an attribute, one for every combination of what that rule
# looks at: size, weight and colours of the text, grounds below it, what else lies over or under it, and whether the rule would pass it over (controls that
# are disabled, text that is clipped, single characters).
ALIKE = "data-one-of-alike"
MARK_ONE_OF_ALIKE = r"""attribute => {
    const [chosen, grounds] = [new Map(), new Map()];
    const all = [...document.querySelectorAll('body *')].filter(e => e.checkVisibility()).map(e => ({ e, s: getComputedStyle(e), at: e.getBoundingClientRect() }));
    const painted = all.filter(({ e, s, at }) => at.width && at.height && (!/, 0\)$/.test(s.backgroundColor) || s.backgroundImage !== 'none' || e.matches('img, canvas, svg')));
    const ground = (e) => {
        if (!e) return '';
        if (!grounds.has(e)) { const s = getComputedStyle(e); grounds.set(e, `${ground(e.parentElement)} ${s.backgroundColor} ${s.backgroundImage} ${s.opacity} ${s.clip} ${s.clipPath}`.replaceAll(' rgba(0, 0, 0, 0) none 1 auto none', '')); }
        return grounds.get(e); };
    const across = ({ e, at }) => painted.flatMap((p, i) => p.at.left < at.right && p.at.right > at.left && p.at.top < at.bottom && p.at.bottom > at.top && !p.e.contains(e) ? [i] : []);
    for (const part of all) {
        const { e, s, at } = part;
        const control = e.matches('input, select, textarea, button');
        const text = [...e.childNodes].filter(n => n.nodeType === 3).map(n => n.data).join(' ').trim();
        if (!control && !text) continue;
        const off = e.closest('[aria-disabled=true], :disabled') !== null || e.closest('label')?.control?.disabled;
        const key = [s.color, s.fontSize, s.fontWeight, s.textShadow, ground(e), across(part), control ? e.type : '', off, /[\p{L}\p{N}]{2}/u.test(text), at.width > 1 && at.height > 1].join();
        if (!chosen.has(key)) chosen.set(key, e);
    }
    chosen.forEach(e => e.setAttribute(attribute, '')); }"""

# What plotly.js draws is named as one picture, and is most of the elements of a page of results: it is taken out meanwhile, and its place kept.
RUN = f"""async ([rules, attribute]) => {{
    const plots = [...document.querySelectorAll('.js-plotly-plot')].map(place => [place, place.style.minHeight, place.offsetHeight, [...place.childNodes]]);
    plots.forEach(([place, , height]) => {{ place.style.minHeight = `${{height}}px`; place.replaceChildren(); }});
    ({MARK_ONE_OF_ALIKE})(attribute);
    try {{ return (await axe.run({{include: document, exclude: ['.js-plotly-plot']}}, rules)).violations; }}
    finally {{
        document.querySelectorAll(`[${{attribute}}]`).forEach(e => e.removeAttribute(attribute));
        plots.forEach(([place, least, , parts]) => {{ place.style.minHeight = least; place.append(...parts); }});
    }} }}"""


def violations(page, rules=RULES):
    """What axe-core finds on the page; its program is read once per page."""
    if not page.evaluate("'axe' in window"):
        page.evaluate(AXE)
        page.evaluate("attribute => axe.configure({rules: [{id: 'color-contrast', selector: `[${attribute}]`}]})", ALIKE)
    return [(v["id"], v["help"], [n["html"][:140] for n in v["nodes"][:4]]) for v in page.evaluate(RUN, [rules, ALIKE])]


def check_accessible(page, name):
    """What axe-core finds by WCAG 2.1, levels A and AA; contrast in the other theme as well."""
    found = violations(page)
    assert not found, f"{name}: {found}"
    other = page.evaluate("""() => { const colours = () => getComputedStyle(document.body).color + getComputedStyle(document.body).backgroundColor;
        const [before, other] = [colours(), matchMedia('(prefers-color-scheme: dark)').matches ? 'light' : 'dark'];
        document.documentElement.dataset.theme = other;
        return colours() === before ? null : other; }""")
    # Reports are of paper: they have one theme.
    found = violations(page, CONTRAST) if other else []
    page.evaluate("delete document.documentElement.dataset.theme")
    assert not found, f"{name}, {other}: {found}"


def check_contrast(page):
    for theme in ["light", "dark"]:
        page.evaluate(f"document.documentElement.dataset.theme = '{theme}'")
        values = page.evaluate("names => Object.fromEntries(names.map(n => [n, getComputedStyle(document.documentElement).getPropertyValue(n).trim()]))", sorted({n for pair in PAIRS for n in pair}))
        for front, ground in PAIRS:
            ratio = contrast(values[front], values[ground])
            assert ratio >= LEAST_CONTRAST, f"{theme}: {front} on {ground} has a contrast of {ratio:.2f}"
    page.evaluate("delete document.documentElement.dataset.theme")


def contrast(one, other):
    def luminance(colour):
        parts = [int(colour[i:i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    light, dark = sorted([luminance(one), luminance(other)], reverse=True)
    return (light + 0.05) / (dark + 0.05)
