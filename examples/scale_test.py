#!/usr/bin/env python3
"""One design on several workers: how much faster does each make it?

    DATABASE_URL=postgres://…/empty python3 examples/scale_test.py --program target/release/dynident --wrap 'taskset -c {cpu}'

For every number of workers a design of the iiwa 14 is searched for with every seed, each worker a process of its own behind `--wrap`, where
{cpu} is its number modulo the processors of this machine and {number} its number. Prints evaluations per second, the best value found, and
what the database had to do for it: transactions and bytes of its log."""
import argparse
import contextlib
import json
import os
import shlex
import subprocess
import tempfile
import time
import urllib.request


def ask(url, path, body=None, wait=0):
    headers = {"Content-Type": "application/json", "Prefer": f"wait={wait}", "Cache-Control": "no-cache"}
    request = urllib.request.Request(url + path, json.dumps(body).encode() if body else None, headers)
    with urllib.request.urlopen(request, timeout=wait + 60) as answer:
        return json.load(answer)


@contextlib.contextmanager
def process(command, folder):
    child = subprocess.Popen([*command, "--data", folder, "--log", "warn"], stdout=subprocess.PIPE, text=True)
    try:
        yield child.stdout.readline().strip()
    finally:
        child.terminate()
        child.wait()


def query(sql):
    output = subprocess.run(["psql", "-tA", os.environ["DATABASE_URL"], "-c", sql], check=True, capture_output=True, text=True)
    return float(output.stdout)


def written():
    """Transactions and bytes of the database's log so far."""
    time.sleep(1.5)  # The statistics of PostgreSQL come in a second late.
    commits = query("SELECT xact_commit FROM pg_stat_database WHERE datname = current_database()")
    return commits, query("SELECT pg_wal_lsn_diff(pg_current_wal_lsn(), '0/0')")


def design(url, seed, seconds, rate):
    request = {
        "robot": "iiwa14", "fourier": {"order": 5, "fundamental_hz": 0.1}, "sample_rate_hz": rate,
        "search": {"seed": seed, "time_limit_s": seconds},
    }
    before = written()
    started = time.time()
    result = ask(url, "/excitation", request, wait=int(seconds) + 60)
    elapsed = time.time() - started
    after = written()
    search = result["search"]
    return {
        "seed": seed, "best": result["condition_number"], "searches": search["searches"], "evaluations": search["evaluations"],
        "per_s": search["evaluations"] / seconds, "late_s": elapsed - seconds,
        "transactions": after[0] - before[0], "log_bytes": after[1] - before[1],
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="dynident")
    parser.add_argument("--workers", default="1,2,3")
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--rate-hz", type=float, default=100)
    parser.add_argument("--wrap", default="taskset -c {cpu}")
    arguments = parser.parse_args()
    numbers = lambda text: [int(n) for n in text.split(",")]
    alone = None
    for workers in numbers(arguments.workers):
        with contextlib.ExitStack() as stack:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            serve = [arguments.program, "serve", "--listen", "127.0.0.1:0", "--concurrent-jobs", "0", "--short-jobs", "0"]
            url = stack.enter_context(process(serve, folder + "/server")).removeprefix("listening on ")
            for number in range(workers):
                wrap = shlex.split(arguments.wrap.format(cpu=number % os.cpu_count(), number=number))
                stack.enter_context(process([*wrap, arguments.program, "worker"], f"{folder}/{number}"))
            time.sleep(1)
            runs = [design(url, seed, arguments.seconds, arguments.rate_hz) for seed in numbers(arguments.seeds)]
        for run in runs:
            print(json.dumps({"workers": workers, **run}), flush=True)
        mean = sum(run["per_s"] for run in runs) / len(runs)
        alone = alone or mean / workers
        print(f"{workers} workers: {mean:.0f} evaluations per second, {mean / alone:.2f} times one worker's", flush=True)


if __name__ == "__main__":
    main()
