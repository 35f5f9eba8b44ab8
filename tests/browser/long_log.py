"""160,000 rows of seven joints: drawn in under a second, zoomed without a halt, and no peak lost."""

import urllib.request

from browser import arguments, browser_page, simulate

# From the answer of the interface to the last line on the screen, and for one step of zooming (ms).
LONGEST_DRAWING = 1000
LONGEST_ZOOM = 250


def identify(options, log):
    request = '{"robot": "iiwa14", "feasible": {"method": "none"}, "preprocess": {"average": false, "decimation": 1}, "trace": false, "prediction_points": 6000}'
    boundary = "rows160000"
    part = f'--{boundary}\r\nContent-Disposition: form-data; name='
    body = (f'{part}"request"\r\n\r\n{request}\r\n{part}"log"; filename="long.csv"\r\n\r\n').encode() + log.read_bytes() + f"\r\n--{boundary}--\r\n".encode()
    headers = {"content-type": f"multipart/form-data; boundary={boundary}", "prefer": "wait=120"}
    with urllib.request.urlopen(urllib.request.Request(f"{options.server}/identify", body, headers)) as answer:
        assert answer.status == 200, answer.status
        return answer.headers["content-location"].rsplit("/", 1)[1]


def zoom(page, start, end):
    """Milliseconds until a new range of time is on the screen."""
    return page.evaluate("""async ([start, end]) => {
        const place = document.querySelector('#torques .plot');
        const begun = performance.now();
        await window.Plotly.relayout(place, {'xaxis.range[0]': start, 'xaxis.range[1]': end});
        await new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
        return performance.now() - begun; }""", [start, end])


def main():
    options = arguments()
    with browser_page(options) as page:
        rows = [[0.3, -0.1, 0.2], [0.2, 0.3, -0.4], [-0.2, 0.1, 0.3], [0.1, -0.4, 0.2], [0.4, 0.2, -0.1], [-0.3, 0.2, 0.3], [0.2, -0.2, 0.4]]
        series = {"fourier": {"fundamental_hz": 0.1, "a": rows, "b": rows[::-1]}}
        noise = {"torque": [0.3, 0.3, 0.2, 0.2, 0.12, 0.12, 0.06]}
        log = simulate(options, "iiwa14", {"trajectory": series, "periods": 16, "sample_rate_hz": 1000, "noise": noise, "seed": 1}, page.folder / "long.csv")
        assert sum(1 for _ in log.open()) >= 160_001
        name = identify(options, log)
        drawn = []
        for _ in range(3):
            page.goto(f"{options.server}/identification?id={name}")
            page.wait_for_function("() => document.querySelector('#torques')?.dataset.drawnMs")
            drawn.append(page.evaluate("Number(document.querySelector('#torques').dataset.drawnMs)"))
        # The best of three: what else the machine does is not the page's.
        assert min(drawn) < LONGEST_DRAWING, drawn
        points = page.evaluate("document.querySelector('#torques .plot').data.map(t => t.x.length)")
        assert all(1000 < n <= 2400 for n in points), points
        steps = [zoom(page, 10.0 * k, 10.0 * k + 8.0) for k in range(1, 7)]
        assert sorted(steps)[len(steps) // 2] < LONGEST_ZOOM, steps
        assert not page.trouble, page.trouble


main()
