"""160,000 rows of seven joints: on the screen in under a second, zoomed and panned without a halt, and no peak lost."""

import urllib.request

from browser import arguments, browser_page, simulate

# Milliseconds: from the answer of the interface to the lines on the screen; from asking for the page, which waits for the server and for whatever
# else the machine does; a step of panning.
LONGEST_DRAWING = 1000
LONGEST_OPENING = 3000
LONGEST_STEP = 150
MOST_OPENINGS = 4


def identify(options, log):
    """All rows are read and thinned to the points that are drawn; the fit, which is not what is looked at, takes every twentieth."""
    request = '{"robot": "iiwa14", "feasible": {"method": "none"}, "preprocess": {"average": false, "decimation": 20}, "trace": false, "prediction_points": 6000}'
    boundary = "rows160000"
    part = f'--{boundary}\r\nContent-Disposition: form-data; name='
    body = (f'{part}"request"\r\n\r\n{request}\r\n{part}"log"; filename="long.csv"\r\n\r\n').encode() + log.read_bytes() + f"\r\n--{boundary}--\r\n".encode()
    headers = {"content-type": f"multipart/form-data; boundary={boundary}", "prefer": "wait=120"}
    with urllib.request.urlopen(urllib.request.Request(f"{options.server}/identify", body, headers)) as answer:
        assert answer.status == 200, answer.status
        return answer.headers["content-location"].rsplit("/", 1)[1]


def pan(page, ranges):
    """Milliseconds per range of time until it is on the screen, thinned anew."""
    return page.evaluate("""async (ranges) => {
        const place = document.querySelector('#torques .plot');
        const taken = [];
        for (const [start, end] of ranges) {
            const begun = performance.now();
            await window.Plotly.relayout(place, {'xaxis.range[0]': start, 'xaxis.range[1]': end});
            const shown = () => { const x = place.data[0].x; return x[0] > start - 1 && x.at(-1) < end + 1; };
            // On the screen with the next frame.
            while (!shown() && performance.now() - begun < 5000) await new Promise(done => setTimeout(done, 1));
            await new Promise(done => requestAnimationFrame(done));
            taken.push(performance.now() - begun);
        }
        return taken; }""", ranges)


def main():
    options = arguments()
    with browser_page(options) as page:
        rows = [[0.3, -0.1, 0.2], [0.2, 0.3, -0.4], [-0.2, 0.1, 0.3], [0.1, -0.4, 0.2], [0.4, 0.2, -0.1], [-0.3, 0.2, 0.3], [0.2, -0.2, 0.4]]
        series = {"fourier": {"fundamental_hz": 0.1, "a": rows, "b": rows[::-1]}}
        noise = {"torque": [0.3, 0.3, 0.2, 0.2, 0.12, 0.12, 0.06]}
        log = simulate(options, "iiwa14", {"trajectory": series, "periods": 16, "sample_rate_hz": 1000, "noise": noise, "seed": 1}, page.folder / "long.csv")
        assert sum(1 for _ in log.open()) >= 160_001
        name = identify(options, log)
        drawn, opened = [], []
        while not drawn or len(drawn) < MOST_OPENINGS and (min(drawn) >= LONGEST_DRAWING or min(opened) >= LONGEST_OPENING):
            page.goto(f"{options.server}/identification?id={name}")
            page.wait_for_function("() => document.querySelector('#torques')?.dataset.drawnAt")
            drawn.append(page.evaluate("Number(document.querySelector('#torques').dataset.drawnMs)"))
            opened.append(page.evaluate("Number(document.querySelector('#torques').dataset.drawnAt)"))
        # The best of them: what else the machine does is not the page's. One that is quick enough is the best as well as any.
        assert min(drawn) < LONGEST_DRAWING, drawn
        assert min(opened) < LONGEST_OPENING, opened
        points = page.evaluate("document.querySelector('#torques .plot').data.map(t => t.x.length)")
        assert all(1000 < n <= 2400 for n in points), points
        # What is highest and lowest in all that the interface gave is in the points drawn of it.
        drawn_of, given = page.evaluate("""async (name) => {
            const one = (await (await fetch(`/identify/${name}`)).json()).predictions.find(s => s.joint === 'A1');
            const ends = (y) => [Math.min(...y), Math.max(...y)];
            const [measured, predicted, difference] = document.querySelector('#torques .plot').data.map(t => ends(t.y));
            return [[measured, predicted, difference], [one.measured, one.base, one.measured.map((m, i) => m - one.base[i])].map(ends)]; }""", name)
        assert drawn_of == given, (drawn_of, given)
        steps = sorted(pan(page, [[10.0 + 4.0 * k, 18.0 + 4.0 * k] for k in range(24)]))
        assert steps[len(steps) // 2] < LONGEST_STEP, steps
        if options.pictures:
            print(drawn, opened, [round(s) for s in steps], points)
        assert not page.trouble, page.trouble


main()
