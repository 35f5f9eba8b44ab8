"""Periodic logs as controllers write them, at 500 Hz (Universal Robots) and 1 kHz (KUKA FRI): from the page to the result and its report, and as pictures."""

import subprocess

from accessible import check_accessible
from browser import LONGEST_RUN_S, arguments, browser_page, check, settle, simulate

NOISE = [0.3, 0.2]


def log(options, folder, rate):
    series = {"fourier": {"fundamental_hz": 0.2, "a": [[0.4, -0.2], [0.3, 0.3]], "b": [[0.1, 0.2], [-0.2, 0.1]]}}
    request = {"trajectory": series, "periods": 4, "sample_rate_hz": rate, "noise": {"torque": NOISE}, "seed": 2}
    return simulate(options, "planar_two_link", request, folder / f"rate{rate}.csv")


def pictures(options, path, folder):
    out = folder / f"pictures-{path.stem}"
    command = [options.program, "identify", "--robot", "planar_two_link", "--log", str(path), "--validation", str(path), "--out", str(folder / "result.json"),
               "--report", str(folder / "report.html"), "--plots", str(out)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_RUN_S)
    assert ran.returncode == 0, ran.stderr
    assert len(list(out.iterdir())) >= 3 and (folder / "report.html").stat().st_size > 10_000


def main():
    options = arguments()
    with browser_page(options) as page:
        for rate in [500, 1000]:
            path = log(options, page.folder, rate)
            page.goto(f"{options.server}/identification?robot=planar_two_link")
            page.locator("#robot option").first.wait_for(state="attached")
            page.select_option("#robot", "planar_two_link")
            page.set_input_files("#log", path)
            page.locator("#result h2", has_text=path.name).wait_for()
            page.set_input_files("#validation", path)
            page.locator("#result h2", has_text=path.name).nth(1).wait_for()
            page.click("#go")
            page.locator("#torques").wait_for(timeout=120_000)
            settle(page)
            check(page, f"{rate} Hz")
            shown = page.evaluate("document.querySelector('#torques .plot').data.map(t => t.x.length)")
            assert shown and all(n > 100 for n in shown), shown
            name = page.url.split("id=")[1]
            answer = page.goto(f"{options.server}/identify/{name}/report")
            assert "default-src 'none'" in answer.headers["content-security-policy"] and "script-src" not in answer.headers["content-security-policy"]
            assert page.locator("meta[http-equiv=Content-Security-Policy]").count() == 1
            assert page.locator("svg").count() >= 3
            check_accessible(page, f"report at {rate} Hz")
            pictures(options, path, page.folder)


main()
