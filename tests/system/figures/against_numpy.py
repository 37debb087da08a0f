"""Every figure of a session against numpy, and on walks whose truth is known.

    against_numpy.py FOLDER_OF_PROGRAMS

The walks are made here, recorded by `record_walks`, and read back as `hoist export` gives them; the figures are those of `hoist metrics`.
"""
import io
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from formulas import DEGREE, Pattern, figures  # noqa: E402
from harness import check, run_suite  # noqa: E402

FOLDER = sys.argv[1]
COLUMNS = ("mode", "standing_still", "fused_x_m", "fused_y_m", "fused_psi_rad", "dpsi_rad", "dy_m", "speed_m_s")
EIGHT = {"shape": "eight", "centre_m": 1.0, "radius_m": 0.8}
SQUARE = {"shape": "square", "side_m": 3.2}
USER, REMOTE, STANDBY, PROTECTIVE_STOP = 2, 3, 1, 4


def hoist(*arguments):
    return subprocess.run([os.path.join(FOLDER, "hoist"), *arguments], check=True, capture_output=True, text=True).stdout


def ramped(seconds, speed, at_ends=2.0):
    t = np.arange(0, seconds, 0.01)
    return speed * np.clip(np.minimum(t, seconds - t) / at_ends, 0, 1)


def sway(count, cadence, asymmetry, random, jitter=0.01, amplitude=0.02, noise=0.001):
    """The way from right to left takes longer than the way back by `asymmetry` of their mean."""
    out = []
    while len(out) < count + 1000:
        stride = 120 / cadence * (1 + jitter * random.standard_normal())
        for way, part in ((-1, 0.5 + asymmetry / 4), (1, 0.5 - asymmetry / 4)):
            begin = out[-1][0] if out else 0.0
            end = begin + stride * part
            out += [(t, way * np.cos(np.pi * (t - begin) / (end - begin))) for t in np.arange(np.ceil(begin * 100) / 100, end, 0.01)]
            out.append((end, -way))
    times, values = np.array(sorted(set(out))).T
    return amplitude * np.interp(np.arange(count) * 0.01, times, values) + noise * random.standard_normal(count)


class Walk:
    def __init__(self, exercise, speed, psi, x, y, dpsi, dy, mode=USER):
        self.exercise, count = exercise, len(speed)
        self.columns = {"tick": np.arange(count) + 1000, "mode": np.full(count, mode), "standing": (np.abs(speed) < 0.02).astype(int), "x": x, "y": y,
                        "psi": psi, "dpsi": dpsi, "dy": dy, "speed": speed, "distance": np.concatenate(([0], np.cumsum(np.abs(speed[:-1]) * 0.01)))}
        for part in (slice(0, 50), slice(count - 50, count)):
            self.columns["mode"][part] = STANDBY

    def cut(self, first, end):
        keep = np.r_[0:first, end : len(self.columns["tick"])]
        self.columns = {name: values[keep] for name, values in self.columns.items()}
        return self

    def text(self):
        rows = np.column_stack(list(self.columns.values()))
        out = io.StringIO()
        np.savetxt(out, rows, fmt=["%d"] * 3 + ["%.6f"] * 7)
        return f"walk {json.dumps(self.exercise) if self.exercise else 'free'}\n" + out.getvalue()


def along(exercise, laps, random, mode=USER, cadence=70, pelvis=1.0):
    """Along a figure, a little beside it; the pelvis turns 0.4 s before the hoist."""
    pattern = Pattern(exercise)
    speed = np.concatenate((np.zeros(100), ramped(laps * pattern.length / 0.3 + 2, 0.3), np.zeros(100)))
    s = np.concatenate(([0], np.cumsum(speed[:-1] * 0.01)))
    x, y, psi = np.array([pattern.pose(at) for at in s]).T
    kernel = np.hanning(121) / np.sum(np.hanning(121))  # nobody turns at once
    psi = np.convolve(np.pad(psi, 60, mode="edge"), kernel, "valid")
    beside = 0.06 * np.sin(s) * np.clip(s, 0, 1)
    turn = np.gradient(psi, 0.01)
    dpsi = pelvis * 0.5 * np.roll(turn, -40) + 0.01 * random.standard_normal(len(s))
    return Walk(exercise, speed + 0.004 * random.standard_normal(len(s)) * (speed > 0), psi + 0.03 * np.sin(1.7 * s), x - beside * np.sin(psi),
                y + beside * np.cos(psi), dpsi, sway(len(s), cadence, 0.1, random) * np.clip(speed / 0.15, 0, 1), mode)


def free(angles, random, cadence=80, asymmetry=0.0, straight_s=6.0, rate=30 * DEGREE):
    """Straight ways with a turn of each angle between them."""
    psi, now = [np.zeros(int(straight_s * 100))], 0.0
    for angle in angles:
        t = np.arange(0, abs(angle) / rate * 2, 0.01) / (abs(angle) / rate * 2)
        psi.append(now + angle * (t - np.sin(2 * np.pi * t) / (2 * np.pi)))  # as fast as `rate` in the mean of its middle
        now += angle
        psi.append(np.full(int(straight_s * 100), now))
    psi = np.concatenate(psi)
    speed = ramped(len(psi) * 0.01 - 0.001, 0.3)[: len(psi)]
    x, y = np.cumsum(speed * np.cos(psi) * 0.01), np.cumsum(speed * np.sin(psi) * 0.01)
    return Walk(None, speed, psi, x, y, 0.4 * np.gradient(psi, 0.01), sway(len(psi), cadence, asymmetry, random))


def recorded(walks, folder):
    database = os.path.join(folder, "hoist.db")
    subprocess.run([os.path.join(FOLDER, "record_walks"), database], input="".join(walk.text() for walk in walks), text=True, check=True)
    told = [json.loads(line) for line in hoist("metrics", database, "all").splitlines()]
    check(len(told) == len(walks), f"{len(told)} sessions of {len(walks)}")
    return database, told


def columns_of(database, session):
    text = hoist("export", database, str(session), "--no-comments", "--columns", "tick," + ",".join(COLUMNS))
    names, *rows = (line.split(",") for line in text.splitlines())
    values = np.array([row[1:] for row in rows], dtype=float)
    columns = {name.replace("fused_", ""): values[:, i] for i, name in enumerate(names[1:])}
    return {name: values.astype(int) if name in ("tick", "mode", "standing_still") else values for name, values in columns.items()}


def walks_of_all_kinds(random):
    stopped = along(EIGHT, 2, random)
    stopped.columns["mode"][4000:4200] = PROTECTIVE_STOP
    handed = free([np.pi / 2, -np.pi], random)
    handed.columns["mode"][1500:2500] = REMOTE
    paused = free([np.pi], random)
    for name in ("speed", "dy"):
        paused.columns[name][800:1000] = 0
    paused.columns["standing"][800:1000] = 1
    return [along(EIGHT, 2, random), along(SQUARE, 2, random, REMOTE), along(EIGHT, 1, random, pelvis=-0.5), along({"shape": "straight", "length_m": 10.0}, 1, random),
            stopped, handed, paused, free([], random), along(EIGHT, 2, random).cut(3000, 3040), along(EIGHT, 2, random).cut(3000, 3100),
            free([np.pi / 2, np.pi], random).cut(1500, 1700)]


def every_figure_is_the_one_of_its_formula():
    tolerance = {"step_asymmetry_norm": 2e-3}
    seen = {}
    with tempfile.TemporaryDirectory() as folder:
        database, told = recorded(walks_of_all_kinds(np.random.default_rng(1)), folder)
        for one in told:
            exercise = json.loads(json.dumps(one["exercise"]))
            if exercise and "c_m" in exercise:
                exercise["centre_m"] = exercise.pop("c_m")
            mine = figures(columns_of(database, one["session"]), exercise)
            check(set(mine) == set(one["computed"]), f"figures without a formula here: {set(mine) ^ set(one['computed'])}")
            for key, value in mine.items():
                name = f"session {one['session']}, {key}: {one[key]} ({one['computed'][key]['reason_code']}), numpy {value}"
                check((value is None) == (one[key] is None), name)
                if value is not None:
                    check(abs(value - one[key]) <= tolerance.get(key, 1e-7 * max(1, abs(value))), name)
                    seen.setdefault(key, set()).add(round(float(value), 6))
    dull = [key for key in told[0]["computed"] if len(seen.get(key, ())) < 2]
    check(not dull, f"these figures were the same in all walks: {dull}")


def cadence_and_asymmetry_are_the_true_ones():
    random = np.random.default_rng(2)
    truths = [(cadence, asymmetry) for cadence in (45, 60, 75, 90, 110) for asymmetry in (-0.2, -0.08, 0.0, 0.1, 0.25)]
    with tempfile.TemporaryDirectory() as folder:
        _, told = recorded([free([], random, cadence, asymmetry, straight_s=75.0) for cadence, asymmetry in truths], folder)
    worst = [0.0, 0.0]
    for one, (cadence, asymmetry) in zip(told, truths):
        off = abs(one["cadence_steps_min"] - cadence), 100 * abs(one["step_asymmetry_norm"] - asymmetry)
        worst = [max(a, b) for a, b in zip(worst, off)]
        check(off[0] <= 1 and off[1] <= 2, f"cadence {cadence} is {one['cadence_steps_min']}, asymmetry {asymmetry} is {one['step_asymmetry_norm']}")
    print(f"  off by at most {worst[0]:.2f} steps a minute and {worst[1]:.2f} points")


def turns_have_their_true_angles():
    random = np.random.default_rng(3)
    truths = [[angle * DEGREE] for angle in (60, -90, 180, -360)] + [[np.pi / 2, -np.pi / 2, np.pi], [-np.pi / 2] * 4]
    with tempfile.TemporaryDirectory() as folder:
        _, told = recorded([free(angles, random) for angles in truths], folder)
    for one, angles in zip(told, truths):
        check((one["turns_left"], one["turns_right"]) == (sum(a > 0 for a in angles), sum(a < 0 for a in angles)), f"turns of {angles}: {one['turns_left']}")
        check(abs(one["turn_angle_rad"] - np.mean(np.abs(angles))) <= 3 * DEGREE, f"{angles}: {one['turn_angle_rad'] / DEGREE} degrees")


def a_pelvis_that_leads_leads_by_as_much():
    with tempfile.TemporaryDirectory() as folder:
        _, (one,) = recorded([along(EIGHT, 2, np.random.default_rng(4))], folder)
    check(abs(one["turn_lead_s"] - 0.4) <= 0.05, f"{one['turn_lead_s']} s instead of 0.4 s")
    check(one["C_best"] >= one["C"] and one["C_best"] > 0.9, f"C {one['C']}, at best {one['C_best']}")
    check(abs(one["completion_norm"] - 2) < 0.02 and abs(one["lap_time_mean_s"] - Pattern(EIGHT).length / 0.3) < 2, "laps")


if __name__ == "__main__":
    sys.exit(run_suite("Figures", [every_figure_is_the_one_of_its_formula, cadence_and_asymmetry_are_the_true_ones, turns_have_their_true_angles,
                                   a_pelvis_that_leads_leads_by_as_much]))
