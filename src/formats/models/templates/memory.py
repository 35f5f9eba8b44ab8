

# Effects with memory: they depend on the samples before the present one, and inverse_dynamics leaves them out.

@MEMORY@

def _between(a, b, u, h):
    """State between two samples that are h apart, at the part u: the quintic through both."""
    out = []
    for (q0, v0, a0), (q1, v1, a1) in zip(a, b):
        v0, v1, a0, a1 = v0 * h, v1 * h, a0 * h * h, a1 * h * h
        d, e, f = q1 - q0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0
        c3, c4, c5 = 10.0 * d - 4.0 * e + 0.5 * f, -15.0 * d + 7.0 * e - f, 6.0 * d - 3.0 * e + 0.5 * f
        out.append((
            q0 + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5)))),
            (v0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h,
            (a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h),
        ))
    return out


def _onward(a, t):
    """Constant acceleration from a sample on."""
    return [(q + v * t + 0.5 * acc * t * t, v + acc * t, acc) for q, v, acc in a]


def _slide(z, distance, width):
    s = sign(distance)
    return z if distance == 0.0 else s + (z - s) * exp(-fabs(distance) / width)


def _presliding(z, a, b, h, width):
    """Dahl 1968: exact over a step where the joint does not turn back within it, else in two parts."""
    (q0, v0, _), (q1, v1, _) = a, b
    if v0 * v1 >= 0.0:
        return _slide(z, q1 - q0, width)
    acceleration = (v1 - v0) / h
    return _slide(_slide(z, -0.5 * v0 * v0 / acceleration, width), 0.5 * v1 * v1 / acceleration, width)


def _reach(sample_time):
    return max(FEWEST, floor(REACH_S / sample_time + 0.5))


def _cubic(values, reach, k):
    """Local cubic over 2 reach + 1 values (Savitzky-Golay): both derivatives by the number of the value, at offset k from the middle."""
    numbers = range(-reach, reach + 1)
    s2, s4, s6 = (float(sum(i**p for i in numbers)) for p in (2, 4, 6))
    x0, x1, x2, x3 = (sum(i**p * v for i, v in zip(numbers, values)) for p in range(4))
    odd, even = s2 * s6 - s4 * s4, len(values) * s4 - s2 * s2
    c1, c2, c3 = (s6 * x1 - s4 * x3) / odd, (len(values) * x2 - s2 * x0) / even, (s2 * x3 - s4 * x1) / odd
    return c1 + 2.0 * c2 * k + 3.0 * c3 * k * k, 2.0 * c2 + 6.0 * c3 * k


def _loads(at, gravity, with_offset):
    q, qd, qdd = zip(*at)
    return _rigid_body([x + o for x, o in zip(q, OFFSET)] if with_offset else q, qd, qdd, gravity)


def _torque_at(at, link, z@CHANNELS@):
    """Bodies move with the links, friction with the motors."""
    q, qd, qdd = zip(*at)
    tau = _torques([x + o for x, o in zip(q, OFFSET)], qd, qdd, _loads(link, GRAVITY, True)@PASS@)
    for (j, level, _), state in zip(HYSTERESIS, z):
        tau[j] += GAIN[j] * level * (state - sign(at[j][1]))
    return tau


def _bent(at, joint, compliance, load, first, second):
    q, v, a = at[joint]
    return at[:joint] + [(q - compliance * load, v - compliance * first, a - compliance * second)] + at[joint + 1:]


def _distort(motion, load, h):
    """Motion of the motors and of the links: a late torque belongs to an earlier sample, elastic joints give way under their loads."""
    reach, last = _reach(h), len(motion) - 1
    links = None
    for joint, value in DISTORTION:
        if joint >= 0:
            bent = []
            for s, at in enumerate(links or motion):
                window = [load[min(max(s + k, 0), last)][joint] for k in range(-reach, reach + 1)]
                first, second = _cubic(window, reach, 0.0)
                bent.append(_bent(at, joint, value, load[s][joint], first / h, second / (h * h)))
            links = bent
            continue
        moved = []
        for s in range(last + 1):
            at = s - value / h
            first = floor(at)
            if at < 0.0 or at > last:
                end = 0 if at < 0.0 else last
                moved.append(_onward(motion[end], (at - end) * h))
            else:
                moved.append(motion[first] if at == first else _between(motion[first], motion[first + 1], at - first, h))
        motion = moved
    return motion, links or motion
@CHANNEL_ROWS@

def predict(q, qd, qdd, sample_time@CHANNELS@):
    """Torques along a whole motion that is known: rows of N values, sample_time (s) apart."""
    given = [[(float(x), float(v), float(a)) for x, v, a in zip(*row)] for row in zip(q, qd, qdd)]
    motion, links = _distort(given, [_loads(at, LEVEL_GRAVITY, False) for at in given], sample_time)
    for _ in range(LOAD_ROUNDS):
        motion, links = _distort(given, [_loads(at, GRAVITY, True) for at in links], sample_time)
    z = [next((sign(at[j][1]) for at in motion if at[j][1] != 0.0), 0.0) for j, _, _ in HYSTERESIS]
    torques = []
    for s, at in enumerate(motion):
        if s > 0:
            z = [_presliding(v, motion[s - 1][j], at[j], sample_time, w) for v, (j, _, w) in zip(z, HYSTERESIS)]
        torques.append(_torque_at(at, links[s], z@PASS_ROW@))
    return torques


class Stepper:
    """The same torques sample by sample, but for elastic joints, whose loads are differentiated looking back only."""

    def __init__(self, sample_time):
        if not sample_time > 0.0:
            raise ValueError("sample_time is the time between samples in s")
        self.sample_time = float(sample_time)
        self._z = [None] * len(HYSTERESIS)
        self._before = None
        self._late = []
        self._load = {}

    def _bend(self, at, key, joint, compliance, load):
        h, reach = self.sample_time, (_reach(self.sample_time) + 1) // 2
        back = self._load.get(key, [load] * (2 * reach + 1))[1:] + [load]
        self._load[key] = back
        first, second = _cubic(back, reach, float(reach))
        return _bent(at, joint, compliance, load, first / h, second / (h * h))

    def step(self, q, qd, qdd@CHANNELS@):
        """Torque for the next sample, N values."""
        # The delay comes first: samples as they are given belong together, bent ones do not.
        now = self._delayed([(float(x), float(v), float(a)) for x, v, a in zip(q, qd, qdd)])
        link = now
        for rounds in range(LOAD_ROUNDS + 1):
            load = _loads(link, GRAVITY if rounds else LEVEL_GRAVITY, rounds > 0)
            link = now
            for d, (joint, value) in enumerate(DISTORTION):
                if joint >= 0:
                    link = self._bend(link, (rounds, d), joint, value, load[joint])
        for i, (j, _, width) in enumerate(HYSTERESIS):
            if self._z[i] is None:
                self._z[i] = float(sign(now[j][1])) or None
            else:
                self._z[i] = _presliding(self._z[i], self._before[j], now[j], self.sample_time, width)
        self._before = now
        return _torque_at(now, link, [z or 0.0 for z in self._z]@PASS@)

    def _delayed(self, at):
        ago = sum(value for joint, value in DISTORTION if joint < 0) / self.sample_time
        self._late = [at] + self._late[:max(0, ceil(ago)) + 1]
        oldest = len(self._late) - 1
        whole = ceil(ago)
        if ago < 0.0 or ago > oldest:
            end = 0 if ago < 0.0 else oldest
            return _onward(self._late[end], (end - ago) * self.sample_time)
        if ago == whole:
            return self._late[whole]
        return _between(self._late[whole], self._late[whole - 1], whole - ago, self.sample_time)
