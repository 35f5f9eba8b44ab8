#!/usr/bin/env python3
"""Many clients on a few robots: is one robot's identification held up by the designs of the others?

    dynident simulate … --out log.csv
    dynident serve --requests-per-second 0 &
    python3 examples/load_test.py http://127.0.0.1:8080 --robot planar_two_link --log log.csv --pid $! --seconds 120

Robot 0 identifies, one job after the other: first alone, then while the clients of the other robots design, identify and look. Prints
the latencies of both, every answer that was not as it should be, and the course of the server's memory."""
import argparse
import http.client
import json
import threading
import time
import urllib.parse


def ask(server, method, path, body=None, headers=None):
    """Status and document of one request."""
    connection = http.client.HTTPConnection(server, timeout=300)
    try:
        connection.request(method, path, body, headers or {})
        answer = connection.getresponse()
        text = answer.read()
        return answer.status, json.loads(text) if text.startswith(b"{") else None
    finally:
        connection.close()


def multipart(request, log):
    head = '--b\r\nContent-Disposition: form-data; name="request"\r\n\r\n%s\r\n' % json.dumps(request)
    head += '--b\r\nContent-Disposition: form-data; name="log"; filename="log.csv"\r\n\r\n'
    return head.encode() + log + b"\r\n--b--\r\n"


def identify(server, robot, log):
    headers = {"Content-Type": "multipart/form-data; boundary=b", "Prefer": "wait=240", "Cache-Control": "no-cache"}
    return ask(server, "POST", "/identify", multipart({"robot": robot}, log), headers)


def design(server, robot, seed, seconds):
    request = {
        "robot": robot, "fourier": {"order": 5, "fundamental_hz": 0.1}, "sample_rate_hz": 50,
        "search": {"seed": seed, "time_limit_s": seconds},
    }
    headers = {"Content-Type": "application/json", "Prefer": "wait=60"}
    return ask(server, "POST", "/excitation", json.dumps(request), headers)


def memory(pid):
    with open(f"/proc/{pid}/status") as status:
        return next(int(line.split()[1]) / 1024 for line in status if line.startswith("VmRSS"))


def percentile(values, part):
    return sorted(values)[min(len(values) - 1, int(part * len(values)))]


class Load:
    def __init__(self, arguments, robots, log):
        self.arguments, self.robots, self.log = arguments, robots, log
        self.server = urllib.parse.urlsplit(arguments.server).netloc
        self.wrong, self.done, self.lock = [], {}, threading.Lock()
        self.until = 0.0

    def count(self, what, status, right):
        with self.lock:
            self.done[what] = self.done.get(what, 0) + 1
            if status not in right:
                self.wrong.append((what, status))

    def client(self, number):
        robot = self.robots[1 + number % (len(self.robots) - 1)]
        turn = 0
        while time.time() < self.until:
            turn += 1
            kind = (number + turn) % 3
            if kind == 0:
                # 202 where the queue is longer than the time a client would wait.
                status, _ = design(self.server, robot, 1000 * number + turn, self.arguments.design_s)
                self.count("design", status, (200, 202))
            elif kind == 1 and number % 10 == 0:
                self.count("identify", identify(self.server, robot, self.log)[0], (200,))
            else:
                self.count("look", ask(self.server, "GET", "/jobs?limit=20")[0], (200,))
            time.sleep(1.0)

    def latencies(self, seconds):
        found, until = [], time.time() + seconds
        while time.time() < until:
            started = time.time()
            status, _ = identify(self.server, self.robots[0], self.log)
            self.count("identify of robot 0", status, (200,))
            found.append(time.time() - started)
        return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("server")
    parser.add_argument("--robot", default="planar_two_link", help="the robot of the log")
    parser.add_argument("--log", required=True)
    parser.add_argument("--pid", type=int, required=True, help="of the server")
    parser.add_argument("--clients", type=int, default=50)
    parser.add_argument("--robots", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--alone-s", type=float, default=20)
    parser.add_argument("--design-s", type=float, default=10)
    arguments = parser.parse_args()
    with open(arguments.log, "rb") as file:
        log = file.read()
    server = urllib.parse.urlsplit(arguments.server).netloc
    document = ask(server, "GET", f"/robots/{arguments.robot}")[1]
    robots = [f"load-{k}" for k in range(arguments.robots)]
    for robot in robots:
        status, answer = ask(server, "PUT", f"/robots/{robot}", json.dumps(document), {"Content-Type": "application/json"})
        assert status in (200, 201), answer
    load = Load(arguments, robots, log)
    alone = load.latencies(arguments.alone_s)
    load.until = time.time() + arguments.seconds
    clients = [threading.Thread(target=load.client, args=(k,)) for k in range(arguments.clients)]
    for client in clients:
        client.start()
    beside, course = [], [memory(arguments.pid)]
    for _ in range(10):
        beside += load.latencies(arguments.seconds / 10)
        course.append(memory(arguments.pid))
    for client in clients:
        client.join()
    for name, found in (("alone", alone), ("beside", beside)):
        print(f"{name}: {len(found)} identifications, median {percentile(found, 0.5):.3f} s, 95 % {percentile(found, 0.95):.3f} s")
    print(f"ratio at 95 %: {percentile(beside, 0.95) / percentile(alone, 0.95):.2f}")
    print(f"requests: {load.done}; wrong: {len(load.wrong)} {load.wrong[:5]}")
    print("memory at tenths of the time:", " ".join(f"{m:.0f}" for m in course), "MB")


if __name__ == "__main__":
    main()
