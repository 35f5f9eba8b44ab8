"""What a foreign page does to the open server of the same machine, in a real browser: it reads nothing, changes nothing, frames nothing; neither from
another port, nor from another site, nor under a foreign name that points to this machine (DNS rebinding)."""

import http.server
import json
import threading
import urllib.request

from browser import arguments, launch
from playwright.sync_api import sync_playwright

DESIGN = {"robot": "planar_two_link", "fourier": {"order": 2, "fundamental_hz": 0.2}, "sample_rate_hz": 20, "search": {"seed": 1, "max_evaluations": 50, "starts": 1}}

# Everything that a page may try without asking anybody, and what it got out of it.
ATTACK = """async ([target, design]) => {
    const tried = {};
    const text = async (name, path, options) => {
        try { const answer = await fetch(target + path, options); tried[name] = `${answer.type} ${answer.status} ${(await answer.text()).length}`; }
        catch (error) { tried[name] = error.name; }
    };
    await text('read', '/jobs', {});
    await text('read blind', '/jobs', {mode: 'no-cors'});
    await text('write', '/excitation', {method: 'POST', headers: {'content-type': 'application/json'}, body: design});
    await text('write blind', '/excitation', {method: 'POST', mode: 'no-cors', body: design});
    const form = new FormData();
    form.append('request', '{"robot": "planar_two_link"}');
    form.append('log', new File(['time,q1,q2,tau1,tau2\\n0,0,0,0,0\\n'], 'a.csv'));
    await text('upload blind', '/identify', {method: 'POST', mode: 'no-cors', body: form});
    await text('delete', '/robots/arm', {method: 'DELETE'});
    const loaded = (tag, path) => new Promise((done) => {
        const element = document.createElement(tag);
        element.onload = () => done('loaded');
        element.onerror = () => done('error');
        element.src = target + path;
        document.body.append(element);
    });
    tried.script = await loaded('script', '/assets/theme.js');
    tried.picture = await loaded('img', '/assets/icon.svg');
    return tried; }"""

# What none of them may be: an answer that is read, or a resource that is used.
HARMLESS = {"read": "TypeError", "read blind": "TypeError opaque", "write": "TypeError", "write blind": "TypeError opaque", "upload blind": "TypeError opaque", "delete": "TypeError",
            "script": "error", "picture": "error"}


class Foreign(http.server.BaseHTTPRequestHandler):
    """The foreign site: an empty page, and one with a form that sends itself."""

    target = ""

    def do_GET(self):
        forms = {"/plain": ("text/plain", "/excitation", json.dumps(DESIGN)), "/multipart": ("multipart/form-data", "/identify", '{"robot": "planar_two_link"}')}
        kind, path, value = forms.get(self.path, ("", "", ""))
        form = f"<form method=post enctype='{kind}' action='{self.target}{path}'><textarea name=request>{value}</textarea></form><script>document.forms[0].submit()</script>" if kind else ""
        frame = f"<iframe src='{self.target}/'></iframe>" if self.path == "/frame" else ""
        link = f"<a href='{self.target}/identification'>See the result</a>" if self.path == "/link" else ""
        page = f"<!doctype html><title>foreign</title><body>{form}{frame}{link}".encode()
        self.send_response(200)
        self.send_header("content-type", "text/html; charset=utf-8")
        self.send_header("content-length", str(len(page)))
        self.end_headers()
        self.wfile.write(page)

    def log_message(self, *_):
        pass


def stored(server):
    with urllib.request.urlopen(f"{server}/jobs") as answer:
        jobs = json.load(answer)["jobs"]
    with urllib.request.urlopen(f"{server}/robots/arm") as answer:
        assert answer.status == 200
    return jobs


def keep_robot(server):
    arm = {"name": "arm", "joints": [{"name": "J1", "kind": "revolute", "mdh": {"alpha": 0, "d": 0, "theta": 0, "r": 0}, "limits": {"velocity": 1}}]}
    request = urllib.request.Request(f"{server}/robots", json.dumps(arm).encode(), {"content-type": "application/json"})
    assert urllib.request.urlopen(request).status == 201


def from_foreign_page(page, server, site):
    page.goto(f"{site}/")
    tried = page.evaluate(ATTACK, [server, json.dumps(DESIGN)])
    assert set(tried) == set(HARMLESS), tried
    for name, got in tried.items():
        # An answer to a blind request is opaque: without status, without text. Most are not even that.
        assert got.split(" ")[0] in HARMLESS[name].split(" "), f"{site}: {name}: {got}"
        assert not got.startswith("opaque") or got == "opaque 0 0", f"{site}: {name}: {got}"
    for path in ["/plain", "/multipart"]:
        with page.expect_navigation(url=f"{server}/**") as waiting:
            page.goto(f"{site}{path}")
        answer = waiting.value
        assert answer.status == 403 and answer.json()["code"] == "cross_site", f"{site}{path}: {answer.status}"
    page.goto(f"{site}/frame")
    page.wait_for_timeout(300)
    inside = page.frames[1]
    assert inside.evaluate("document.querySelector('#main') === null") if inside.url.startswith(server) else True, f"{site}: framed"
    # A link is followed: whoever clicks it sees the page, and the foreign site does not.
    page.goto(f"{site}/link")
    page.get_by_role("link", name="See the result").click()
    page.get_by_role("heading", name="Identification").first.wait_for()
    assert stored(server) == [], f"{site}: something was begun"


def rebound(page, server):
    """A page whose name pointed elsewhere when it was loaded, and points here now: for the browser all requests are of the same origin. The page that is
    shown of the refusal stands for it, its own policy switched off."""
    name = server.replace("127.0.0.1", "evil.example")
    answer = page.goto(f"{name}/")
    assert answer.status == 421 and answer.json()["code"] == "wrong_host", answer.status
    for path, options in [("/jobs", {}), ("/robots", {}), ("/robots/arm", {"method": "DELETE"}), ("/excitation", {"method": "POST", "headers": {"content-type": "application/json"}, "body": json.dumps(DESIGN)})]:
        status, text = page.evaluate("async ([path, options]) => { const answer = await fetch(path, options); return [answer.status, await answer.text()]; }", [path, options])
        assert status == 421 and json.loads(text)["code"] == "wrong_host", f"{path}: {status} {text}"
    assert stored(server) == []


def own_page(page, server):
    """The same requests from the server's own pages, under the names that are its own: what is refused above is refused for where it comes from."""
    for name in [server, server.replace("127.0.0.1", "localhost")]:
        page.goto(name)
        read, begun = page.evaluate("""async (design) => {
            const read = await fetch('/jobs');
            const begun = await fetch('/excitation', {method: 'POST', headers: {'content-type': 'application/json'}, body: design});
            return [read.status, begun.status]; }""", json.dumps(DESIGN))
        assert (read, begun) in [(200, 202), (200, 200)], (name, read, begun)


def docs(page, server):
    """Swagger UI works under the policy of the pages."""
    trouble = []
    page.on("console", lambda m: trouble.append(m.text) if m.type == "error" else None)
    page.goto(f"{server}/docs/")
    page.locator(".opblock").first.wait_for()
    assert page.locator(".opblock").count() > 15
    assert not trouble, trouble


def main():
    options = arguments()
    Foreign.target = options.server
    foreign = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Foreign)
    threading.Thread(target=foreign.serve_forever, daemon=True).start()
    port = foreign.server_address[1]
    keep_robot(options.server)
    with sync_playwright() as playwright:
        rules = "MAP evil.example 127.0.0.1, MAP other.example 127.0.0.1"
        # What newer versions of the browser refuse by themselves is allowed here: others do not.
        trusting = "LocalNetworkAccessChecks,BlockInsecurePrivateNetworkRequests,PrivateNetworkAccessForNavigations"
        browser = launch(playwright, f"--host-resolver-rules={rules}", f"--disable-features={trusting}")
        # Another port of this machine, another name of it, another site.
        for site in ["127.0.0.1", "localhost", "other.example"]:
            page = browser.new_page()
            from_foreign_page(page, options.server, f"http://{site}:{port}")
            page.close()
        page = browser.new_context(bypass_csp=True).new_page()
        rebound(page, options.server)
        page = browser.new_page()
        docs(page, options.server)
        own_page(page, options.server)
        browser.close()


main()
