#!/usr/bin/env python3
"""What it costs to identify in a process of its own: latency with and without isolation, in turns, on one machine.

    python3 examples/isolation_latency.py target/release/dynident --count 100

`--other PROGRAM` asks a third server, of another version of the program, in the same turns."""
import argparse
import contextlib
import http.client
import json
import statistics
import subprocess
import tempfile
import time

SERIES = {"fundamental_hz": 0.2, "a": [[0.5, -0.3, 0.2], [0.2, 0.4, -0.6]], "b": [[0.1, 0.4, -0.3], [-0.4, 0.2, 0.3]]}


def simulated(program, folder, seconds, rate):
    request = {"trajectory": {"fourier": SERIES}, "periods": round(seconds / 5), "sample_rate_hz": rate, "seed": 1, "noise": {"torque": [0.05, 0.03]}}
    with open(f"{folder}/simulation.json", "w") as file:
        json.dump(request, file)
    command = [program, "simulate", "--robot", "planar_two_link", "--request", f"{folder}/simulation.json"]
    return subprocess.run(command, check=True, capture_output=True).stdout


@contextlib.contextmanager
def server(program, folder, name, *arguments):
    command = [program, "serve", "--listen", "127.0.0.1:0", "--data", f"{folder}/{name}", "--requests-per-second", "0", "--log", "warn", *arguments]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        yield process.stdout.readline().strip().removeprefix("listening on http://")
    finally:
        process.terminate()
        process.wait()


def identify(address, log, trace):
    """Time of one identification, from the request to its result (s)."""
    head = '--b\r\nContent-Disposition: form-data; name="request"\r\n\r\n%s\r\n' % json.dumps({"robot": "planar_two_link", "trace": trace})
    head += '--b\r\nContent-Disposition: form-data; name="log"; filename="log.csv"\r\n\r\n'
    headers = {"Content-Type": "multipart/form-data; boundary=b", "Prefer": "wait=60", "Cache-Control": "no-cache"}
    started = time.monotonic()
    connection = http.client.HTTPConnection(address, timeout=90)
    connection.request("POST", "/identify", head.encode() + log + b"\r\n--b--\r\n", headers)
    answer = connection.getresponse()
    text = answer.read()
    connection.close()
    assert answer.status == 200, text[:300]
    return time.monotonic() - started


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program")
    arguments.add_argument("--other", metavar="PROGRAM")
    arguments.add_argument("--count", type=int, default=100)
    arguments.add_argument("--seconds", type=float, default=15, help="length of the log")
    arguments.add_argument("--rate-hz", type=float, default=100)
    arguments.add_argument("--trace", action="store_true", help="look for effects as well")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        log = simulated(given.program, folder, given.seconds, given.rate_hz)
        servers = {
            "with isolation": stack.enter_context(server(given.program, folder, "with")),
            "without": stack.enter_context(server(given.program, folder, "without", "--isolate", "false")),
        }
        if given.other:
            servers["other program"] = stack.enter_context(server(given.other, folder, "other"))
        times = {name: [] for name in servers}
        for turn in range(given.count + 3):
            for name, address in servers.items():
                took = identify(address, log, given.trace)
                # The first ones read pages of the program from the disk.
                if turn >= 3:
                    times[name].append(took)
    base = statistics.median(times["without"])
    for name, all_times in times.items():
        median, late = statistics.median(all_times), statistics.quantiles(all_times, n=20)[-1]
        print(f"{name:15} median {median * 1e3:7.1f} ms, 95th percentile {late * 1e3:7.1f} ms, ratio of medians {median / base:.2f}")


if __name__ == "__main__":
    main()
