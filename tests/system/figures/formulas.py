"""The figures of a session in numpy, from the formulas that `hoist metrics --list` prints and from nothing else.

Input: the columns of `hoist export`. Output: a number, or None where the gate is not met.
"""
import numpy as np

MOVING = (2, 3, 6)  # USER, REMOTE, GUIDED
USER, STANDBY = 2, 1
STOPPED = (4, 7, 8)
DEGREE = np.pi / 180
# Parameters of the recordings that record_walks makes: the table's usual values.
DEAD_BAND, LEAN_RANGE, STRUT_LENGTH = 0.05, 0.157079633, 0.8


class Pattern:
    """A figure on the floor as pieces (length, curvature), each with the pose at its begin."""

    def __init__(self, exercise):
        shape = exercise["shape"]
        self.closed = shape != "straight"
        if shape == "straight":
            start, pieces = (0, 0, 0), [(exercise["length_m"], 0, 0)]
        elif shape == "square":
            side = exercise["side_m"]
            start, pieces = (-side / 2, -side / 2, 0), [(side, 0, np.pi / 2)] * 4
        else:
            c, r = exercise["centre_m"], exercise["radius_m"]
            slope, line = np.arcsin(r / c), np.sqrt(c * c - r * r)
            arc = r * (np.pi + 2 * slope)
            start = (0, 0, slope)
            pieces = [(line, 0, 0), (arc, -1 / r, 0), (2 * line, 0, 0), (arc, 1 / r, 0), (line, 0, 0)]
        self.pieces, self.length, pose = [], 0.0, start
        for length, kappa, corner in pieces:
            self.pieces.append((self.length, length, kappa, pose))
            self.length += length
            x, y, psi = self.on(pose, kappa, length)
            pose = (x, y, psi + corner)
        self.lap_turn = pose[2] - start[2] if shape == "square" else 0.0

    @staticmethod
    def on(pose, kappa, along):
        x, y, psi = pose
        if kappa == 0:
            return x + along * np.cos(psi), y + along * np.sin(psi), psi
        return x + (np.sin(psi + kappa * along) - np.sin(psi)) / kappa, y - (np.cos(psi + kappa * along) - np.cos(psi)) / kappa, psi + kappa * along

    def pose(self, s):
        lap = np.floor(s / self.length) if self.closed else 0
        s -= lap * self.length
        if self.closed and s > self.length - 1e-9:
            lap, s = lap + 1, 0.0
        piece = [p for p in self.pieces if p[0] <= s + 1e-9][-1]
        x, y, psi = self.on(piece[3], piece[2], max(s - piece[0], 0.0))
        return x, y, psi + lap * self.lap_turn

    def project(self, x, y, s0, window):
        """The nearest place in [s0, s0 + window], of all pieces that reach into it."""
        best = None
        for lap in range(int(s0 // self.length) if self.closed else 0, int((s0 + window) // self.length) + 1 if self.closed else 1):
            for begin, length, kappa, (px, py, psi) in self.pieces:
                lo, hi = max(s0, lap * self.length + begin), min(s0 + window, lap * self.length + begin + length)
                if lo > hi:
                    continue
                first, last = lo - lap * self.length - begin, hi - lap * self.length - begin
                if kappa == 0:
                    at = [(x - px) * np.cos(psi) + (y - py) * np.sin(psi)]
                else:
                    cx, cy = px - np.sin(psi) / kappa, py + np.cos(psi) / kappa
                    turn = np.arctan2(y - cy, x - cx) - np.arctan2(py - cy, px - cx)
                    at = [(turn + 2 * np.pi * k) / kappa for k in range(-2, 3)]
                for along in [first, last] + [a for a in at if first < a < last]:
                    gx, gy, _ = self.on((px, py, psi), kappa, along)
                    square = (gx - x) ** 2 + (gy - y) ** 2
                    place = lap * self.length + begin + along
                    if best is None or square < best[0] - 1e-15 or (abs(square - best[0]) <= 1e-15 and place < best[1]):
                        best = (square, place)
        return best[1]


def runs(mask):
    """[first, end) of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(int), [0]))))
    return list(zip(edges[::2], edges[1::2]))


def correlate(x, y, lag=0):
    n = len(x)
    a, b = (x[: n - lag], y[lag:]) if lag >= 0 else (x[-lag:], y[: n + lag])
    return np.sum(a * b) / np.sqrt(np.sum(x * x) * np.sum(y * y))


def best_of(x, y):
    values = [correlate(x, y, lag) for lag in range(-200, 201)]
    return max(values), (int(np.argmax(values)) - 200) * 0.01


def wrap(angle):
    return np.arctan2(np.sin(angle), np.cos(angle))


def path_figures(c, exercise, missing, out):
    keys = ("C", "C_best", "C_best_lag_s", "J_N", "J_T_m_s", "reference_length_m", "rms_pose_m", "rms_position_m", "rms_lateral_m",
            "rms_heading_rad", "cross_track_mean_m", "cross_track_max_m", "completion_norm", "lap_time_mean_s", "lap_time_best_s")
    out.update(dict.fromkeys(keys))
    if exercise is None or missing > 0.5 or len(c["tick"]) == 0 or len(set(c["mode"])) > 1:
        return
    pattern = Pattern(exercise)
    s, reference, at = [], [], 0.0
    for i, (x, y) in enumerate(zip(c["x_m"], c["y_m"])):
        window = 0.5
        if i > 0 and c["tick"][i] - c["tick"][i - 1] > 1:
            window += np.hypot(x - c["x_m"][i - 1], y - c["y_m"][i - 1])
        at = pattern.project(x, y, at, window)
        s.append(at)
        reference.append(pattern.pose(at))
    s, (xr, yr, pr) = np.array(s), np.array(reference).T
    passed = np.diff(c["tick"]) * 0.01
    omega = np.concatenate(([0], np.diff(pr) / passed))
    if np.any(omega != 0) and np.any(c["dpsi_rad"] != 0):
        out["C"] = correlate(c["dpsi_rad"], omega)
        out["C_best"], out["C_best_lag_s"] = best_of(c["dpsi_rad"], omega)
    ex, ey, ep = c["x_m"] - xr, c["y_m"] - yr, wrap(c["psi_rad"] - pr)
    length = np.sum(np.hypot(np.diff(xr), np.diff(yr)))
    total = np.sum(ex**2 + ey**2 + ep**2)
    distance = np.hypot(ex, ey)
    out.update(J_N=total / length, J_T_m_s=total / length / 100, reference_length_m=length, rms_pose_m=np.sqrt(total / len(s)),
               rms_position_m=np.sqrt(np.mean(distance**2)), rms_lateral_m=np.sqrt(np.mean((ey * np.cos(pr) - ex * np.sin(pr)) ** 2)),
               rms_heading_rad=np.sqrt(np.mean(ep**2)), cross_track_mean_m=np.mean(distance), cross_track_max_m=np.max(distance),
               completion_norm=s[-1] / pattern.length)
    left, laps = c["tick"][np.flatnonzero(s <= 0.01)[-1]], []
    while np.any(s >= (len(laps) + 1) * pattern.length - 0.01):
        there = c["tick"][np.argmax(s >= (len(laps) + 1) * pattern.length - 0.01)]
        laps.append((there - left) * 0.01)
        left = there
    if laps:
        out.update(lap_time_mean_s=np.mean(laps), lap_time_best_s=min(laps))
    return pattern, s


def task_figures(c, task, missing, progress, out):
    """progress: the pattern and the arc length of each sample, where the walk is compared with a line."""
    out.update(dict.fromkeys(("task_time_s", "task_distance_m", "timed_speed_m_s", "out_time_s", "turning_time_s", "back_time_s")))
    moved = np.flatnonzero(c["standing_still"] == 0)
    if task is None or len(moved) == 0 or missing > 0.5 or len(set(c["mode"])) > 1:
        return
    begun, tick = moved[0], c["tick"]
    first = lambda mask: begun + np.argmax(mask[begun:]) if np.any(mask[begun:]) else None
    def crossing(left):
        """When it first falls to zero, between two recorded steps by proportion."""
        i = first(left <= 0)
        if i is None or i == begun:
            return None if i is None else tick[i]
        return c["before"][i] + (tick[i] - c["before"][i]) * left[i - 1] / (left[i - 1] - left[i])

    if task["ends"] == "distance":
        if progress is None:
            return
        pattern, s = progress
        end = crossing(task["goal"] * pattern.length - 0.02 - s)
        if end is None:
            return
        out["task_time_s"] = 0.01 * (end - tick[begun])
        if task["edge_m"] > 0:
            a, b = crossing(task["edge_m"] - s), crossing(pattern.length - task["edge_m"] - s)
            out["timed_speed_m_s"] = (pattern.length - 2 * task["edge_m"]) / (0.01 * (b - a))
    elif task["ends"] == "back":
        away, turned = np.hypot(c["x_m"] - c["x_m"][begun], c["y_m"] - c["y_m"][begun]), np.abs(c["psi_rad"] - c["psi_rad"][begun]) / DEGREE
        far = first(away >= task["goal"])
        end = None if far is None else crossing(np.where(np.arange(len(away)) < far, 1, away - 0.3))
        if end is None:
            return
        out["task_time_s"] = 0.01 * (end - tick[begun])
        back = crossing(160 - turned)
        if back is not None and back < end:
            turn = tick[np.flatnonzero((turned <= 20) & (tick < back))[-1]]
            out.update(out_time_s=0.01 * (turn - tick[begun]), turning_time_s=0.01 * (back - turn), back_time_s=0.01 * (end - back))
    elif task["ends"] == "turn":
        end = crossing(task["goal"] - np.abs(c["psi_rad"] - c["psi_rad"][begun]))
        out["task_time_s"] = None if end is None else 0.01 * (end - tick[begun])
    elif task["ends"] == "time":
        end = first(0.01 * (tick - tick[begun]) >= task["goal"])
        out["task_distance_m"] = None if end is None else 0.01 * np.sum(np.abs(c["speed_m_s"][begun:end]))


def lead_figures(c, version, bouts, missing, out):
    """version: of the settings at the session's begin."""
    out.update(dict.fromkeys(("start_latency_s", "stopping_way_m", "dead_band_norm", "effort_s_m", "balance_events")))
    if np.any(c["parameter_version"] != version):
        return
    lean, speed, led, tick = c["lean_norm"], c["speed_m_s"], c["mode"] == USER, c["tick"]
    if missing <= 0.5:
        out["balance_events"] = balance_events(c)
    if not np.any(led):
        return
    beyond = np.abs(lean) > DEAD_BAND
    out["dead_band_norm"] = np.mean(~beyond[led])
    if 0.01 * np.sum(np.abs(speed[led])) >= 1:
        out["effort_s_m"] = np.sum(np.abs(lean[led])) / np.sum(np.abs(speed[led]))
    cuts = np.array([0, *(np.flatnonzero(np.diff(tick) > 1) + 1), len(tick)])
    latencies, ways = [], []
    for first, end in bouts:
        left, right = cuts[cuts <= first][-1], cuts[cuts >= end][0]
        # A start: half a second of rest, and a lean whose beginning is seen.
        if first - left >= 50 and np.all(np.abs(speed[first - 50 : first]) <= 0.05) and np.all(led[first - 50 : first + 1]) and beyond[first]:
            ready = np.flatnonzero(~(beyond & led)[left:first])
            if len(ready) and led[left + ready[-1]]:
                latencies.append(0.01 * (first - left - ready[-1] - 1))
        # A stop: the lean is back within the dead band before the hoist is at rest.
        still = np.flatnonzero((np.abs(speed) <= 0.01)[end:right])
        if len(still) and np.all(led[end : end + still[0] + 1]):
            rest = end + still[0]
            asks = np.flatnonzero(np.sign(speed[end - 1]) * lean[first:rest] > DEAD_BAND)
            if len(asks) and first + asks[-1] + 1 < rest and np.all(led[first + asks[-1] : rest]):
                ways.append(0.01 * np.sum(np.abs(speed[first + asks[-1] + 1 : rest])))
    out["start_latency_s"] = np.mean(latencies) if latencies else None
    out["stopping_way_m"] = np.mean(ways) if ways else None


def balance_events(c):
    tilt, tick = np.arcsin(np.minimum(1, np.hypot(c["dx_m"], c["dy_m"]) / STRUT_LENGTH)), c["tick"]
    later = np.flatnonzero(tick[10:] - tick[:-10] == 10) + 10
    rate = (tilt[later] - tilt[later - 10]) / 0.1
    if len(rate) < 2000:
        return None
    middle = lambda values: np.sort(values)[len(values) // 2]
    limit = middle(rate) + 4 * 1.4826 * middle(np.abs(rate - middle(rate)))
    found = tick[later[(tilt[later] > 0.7 * LEAN_RANGE) & (rate > limit)]]
    return int(len(found) > 0) + int(np.sum(np.diff(found) >= 100))


def bouts_of(c):
    bouts, cuts = [], [0, *(np.flatnonzero(np.diff(c["tick"]) > 1) + 1), len(c["tick"])]
    for first, end in zip(cuts, cuts[1:]):
        bouts += [(first + a, first + b) for a, b in runs(np.abs(c["speed_m_s"][first:end]) > 0.05) if b - a >= 100]
    return bouts


def dose_figures(c, modes, missing, bouts, out):
    speed, turned = np.abs(c["speed_m_s"]), c["standing_still"] == 0
    motion = 0.01 * np.sum(turned)
    walked = 0.01 * np.sum(speed)
    whole = missing <= 0.5
    out.update(under_way_s=0.01 * len(speed), motion_s=motion, missing_s=missing, walked_m=walked, max_speed_m_s=np.max(speed, initial=0),
               mean_speed_m_s=walked / motion if motion > 0 else None, bouts=len(bouts) if whole else None,
               walking_s=0.01 * sum(b - a for a, b in bouts),
               walking_speed_m_s=np.mean(np.concatenate([speed[a:b] for a, b in bouts])) if bouts else None)
    ticks = c["tick"]
    out["stops"] = sum(ticks[b[0]] - ticks[a[1] - 1] > 100 for a, b in zip(bouts, bouts[1:])) if bouts and whole else None
    out["patient_led_norm"] = np.sum(turned & (c["mode"] == USER)) / np.sum(turned) if motion > 0 else None
    order = [m for i, m in enumerate(modes) if i == 0 or m != modes[i - 1]]
    ends = [i for i, m in enumerate(order[:-1]) if m == USER]
    if ends and order[ends[-1] + 1] == STANDBY and not any(m in MOVING for m in order[ends[-1] + 1 :]):
        ends.pop()
    out["interventions"] = len(ends) if USER in order and whole else None
    stops = sum(a in MOVING and b in STOPPED for a, b in zip(order, order[1:]))
    out["protective_stops"] = stops if len(speed) and whole else None


def sways(c, bouts, window=301):
    out = []
    for a, b in bouts:
        if b - a >= 900:
            middle = np.convolve(c["dy_m"][a:b], np.ones(window) / window, "same")
            out.append((c["dy_m"][a:b] - middle)[200:-200])
    return out


def stride_figures(c, bouts, out):
    keys = ("cadence_steps_min", "stride_time_s", "stride_regularity_norm", "step_regularity_norm", "step_symmetry_norm", "stride_time_cv_norm",
            "step_asymmetry_norm", "steps")
    out.update(dict.fromkeys(keys))
    signals = sways(c, bouts)
    steady = sum(len(x) for x in signals)
    if steady < 8 * 60:
        return
    lags = np.arange(0, 352)
    a = np.array([sum(np.dot(x[: len(x) - m], x[m:]) for x in signals) / sum(len(x) - m for x in signals) for m in lags])
    if a[0] < 0.002**2:
        return
    peaks = [m for m in range(60, 351) if a[m] > 0 and a[m] >= a[m - 1] and a[m] > a[m + 1]]
    if not peaks:
        return
    m = next(m for m in peaks if a[m] >= 0.85 * max(a[p] for p in peaks))
    # The vertex of the parabola through three points.
    stride = np.polynomial.Polynomial.fit(lags[m - 1 : m + 2], a[m - 1 : m + 2], 2).deriv().roots()[0]
    at = lambda lag: np.interp(lag, lags, a) / a[0]
    if at(stride) < 0.3 or steady < 8 * stride:
        return
    out.update(cadence_steps_min=12000 / stride, stride_time_s=stride / 100, stride_regularity_norm=at(stride),
               steps=np.round(2 * sum(b - a for a, b in bouts) / stride), step_regularity_norm=abs(at(stride / 2)), step_symmetry_norm=abs(at(stride / 2)) / at(stride))
    times, drawn = [], np.zeros(100)
    signals = sways(c, bouts, 2 * int(stride / 2 + 0.5) + 1)
    size = np.sqrt(np.mean(np.concatenate(signals) ** 2))
    for x in signals:
        crossings, swung = [], False
        for i in range(1, len(x)):
            swung = swung or x[i] < -0.3 * size
            if swung and x[i - 1] < 0 <= x[i]:
                place = i - 1 + x[i - 1] / (x[i - 1] - x[i])
                if not crossings or place - crossings[-1] > stride / 2:
                    crossings.append(place)
                swung = False
        for first, end in zip(crossings, crossings[1:]):
            if end - first <= 1.6 * stride:
                times.append((end - first) / 100)
                drawn += np.interp(first + (end - first) * np.arange(100) / 100, np.arange(len(x)), x)
    if len(times) < 20:
        return
    out["stride_time_cv_norm"] = np.std(times, ddof=1) / np.mean(times)
    spectrum = np.fft.rfft(drawn)
    spectrum[0] = 0
    smooth = np.fft.irfft(np.concatenate((spectrum[:5], np.zeros(10000 - 4))), 20000)
    level = np.sqrt(np.mean(smooth**2))
    left, right = np.argmax(smooth), np.argmin(smooth)
    rise, fall = np.roll(smooth, -right)[: (left - right) % 20000], np.roll(-smooth, -left)[: (right - left) % 20000]
    to_left, to_right = (np.flatnonzero(way > level)[0] - np.flatnonzero(way < -level)[-1] for way in (rise, fall))
    out["step_asymmetry_norm"] = 2 * (to_left - to_right) / (to_left + to_right)


def smooth_figures(c, bouts, out):
    out.update(sparc=None, ldlj=None)
    if not bouts:
        return
    first, end = max(bouts, key=lambda b: b[1] - b[0])
    v = c["speed_m_s"][first:end]
    size = 16 * 2 ** int(np.ceil(np.log2(len(v))))
    spectrum = np.abs(np.fft.fft(v, size))
    spectrum /= spectrum.max()
    spectrum = spectrum[np.arange(size) * 100 / size <= 10]
    loud = np.flatnonzero(spectrum >= 0.05)
    spectrum = spectrum[loud[0] : loud[-1] + 1]
    out["sparc"] = -np.sum(np.hypot(1 / (len(spectrum) - 1), np.diff(spectrum)))
    mean = v[: len(v) // 10 * 10].reshape(-1, 10).mean(axis=1)
    if len(mean) >= 10:
        dt = 0.1
        out["ldlj"] = -np.log((len(mean) * dt) ** 3 / np.max(np.abs(mean)) ** 2 * np.sum(np.diff(mean, 2) ** 2 / dt**4) * dt)


def turn_figures(c, missing, out):
    psi, rate, turns = c["psi_rad"], np.zeros(len(c["tick"])), []
    cuts = [0, *(np.flatnonzero(np.diff(c["tick"]) > 1) + 1), len(psi)]
    for first, end in zip(cuts, cuts[1:]):
        if end - first > 50:
            rate[first + 25 : end - 25] = (psi[first + 50 : end] - psi[first : end - 50]) / 0.5
        parts = []
        for sign in (1, -1):
            found = []
            for a, b in runs(sign * rate[first:end] > DEGREE):
                # Only a gap without a part of the other sign is bridged.
                gap = rate[first + found[-1][1] : first + a] if found else None
                if found and a - found[-1][1] < 30 and not np.any(-sign * gap > DEGREE):
                    found[-1] = (found[-1][0], b)
                else:
                    found.append((a, b))
            parts += found
        turns += [(first + a, first + b) for a, b in parts
                  if np.max(np.abs(rate[first + a : first + b])) > 15 * DEGREE and abs(psi[first + b - 1] - psi[first + a]) > 45 * DEGREE]
    angles = np.array([psi[b - 1] - psi[a] for a, b in turns])
    whole = missing <= 0.5
    out.update(turns_left=np.sum(angles > 0) if whole else None, turns_right=np.sum(angles < 0) if whole else None,
               turn_angle_rad=np.mean(np.abs(angles)) if turns else None,
               turn_time_s=np.mean([0.01 * (b - a) for a, b in turns]) if turns else None, turn_lead_s=None)
    if turns and np.any(c["dpsi_rad"]):
        best, lag = best_of(c["dpsi_rad"], rate)
        out["turn_lead_s"] = lag if best >= 0.3 else None


def figures(columns, exercise, task):
    """columns: of all recorded samples, by name without fused_."""
    moving = np.isin(columns["mode"], MOVING)
    columns["before"] = np.concatenate((columns["tick"][:1], columns["tick"][:-1]))
    c = {name: values[moving] for name, values in columns.items()}
    holes = np.flatnonzero(np.diff(columns["tick"]) > 1)
    missing = 0.01 * sum(columns["tick"][i + 1] - columns["tick"][i] - 1 for i in holes if moving[i] or moving[i + 1])
    out = {}
    bouts = bouts_of(c)
    progress = path_figures(c, exercise, missing, out)
    task_figures(c, task, missing, progress, out)
    lead_figures(c, columns["parameter_version"][0], bouts, missing, out)
    dose_figures(c, list(columns["mode"]), missing, bouts, out)
    stride_figures(c, bouts, out)
    smooth_figures(c, bouts, out)
    turn_figures(c, missing, out)
    return out
