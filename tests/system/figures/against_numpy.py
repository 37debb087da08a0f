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
COLUMNS = ("mode", "standing_still", "fused_x_m", "fused_y_m", "fused_psi_rad", "dpsi_rad", "dy_m", "speed_m_s", "lean_norm", "dx_m", "parameter_version")
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
    def __init__(self, exercise, speed, psi, x, y, dpsi, dy, mode=USER, lean=None, dx=None):
        self.exercise, self.task, count = exercise, None, len(speed)
        lean = np.clip(np.roll(speed, -30) / 0.4, -1, 1) if lean is None else lean
        self.columns = {"tick": np.arange(count) + 1000, "mode": np.full(count, mode), "standing": (np.abs(speed) < 0.02).astype(int), "x": x, "y": y,
                        "psi": psi, "dpsi": dpsi, "dy": dy, "speed": speed, "distance": np.concatenate(([0], np.cumsum(np.abs(speed[:-1]) * 0.01))),
                        "lean": lean, "dx": 0.1 * lean if dx is None else dx, "version": np.ones(count, dtype=int)}
        for part in (slice(0, 50), slice(count - 50, count)):
            self.columns["mode"][part] = STANDBY

    def cut(self, first, end):
        keep = np.r_[0:first, end : len(self.columns["tick"])]
        self.columns = {name: values[keep] for name, values in self.columns.items()}
        return self

    def of(self, name, ends, goal, edge_m=0):
        self.task = {"task": name, "version": 1, "ends": ends, "goal": goal, "edge_m": edge_m, "repetition": 1, "repetitions": 2, "rest_s": 60}
        return self

    def text(self):
        rows = np.column_stack(list(self.columns.values()))
        out = io.StringIO()
        np.savetxt(out, rows, fmt=["%d"] * 3 + ["%.6f"] * 9 + ["%d"])
        exercise = {"shape": "free", **(self.exercise or {}), "task": self.task} if self.task else self.exercise
        return f"walk {json.dumps(exercise) if exercise else 'free'}\n" + out.getvalue()


def along(exercise, laps, random, mode=USER, cadence=70, pelvis=1.0, pace_m_s=0.3):
    """Along a figure, a little beside it; the pelvis turns 0.4 s before the hoist."""
    pattern = Pattern(exercise)
    speed = np.concatenate((np.zeros(100), ramped(laps * pattern.length / pace_m_s + 2, pace_m_s), np.zeros(100)))
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
    return {name: values.astype(int) if name in ("tick", "mode", "standing_still", "parameter_version") else values for name, values in columns.items()}


STRAIGHT = {"shape": "straight", "length_m": 14.0}


def there_and_back(length, rate, random):
    """Out at 0.3 m/s, half a turn on the spot, back."""
    way, turn_s = length / 0.3, np.pi / rate
    t = np.arange(0, 2 * way + turn_s + 2, 0.01) - 1
    speed = 0.3 * (((t >= 0) & (t < way)) | ((t >= way + turn_s) & (t < 2 * way + turn_s)))
    speed = speed + 0.004 * random.standard_normal(len(t)) * (speed > 0)
    psi = np.pi * np.clip((t - way) / turn_s, 0, 1)
    x = 0.3 * (np.clip(t, 0, way) - np.clip(t - way - turn_s, 0, way))
    walk = Walk(None, speed, psi, x, np.zeros(len(t)), 0.4 * np.gradient(psi, 0.01), sway(len(t), 80, 0, random))
    walk.columns["standing"][(t >= way) & (t < way + turn_s)] = 0
    return walk


def walks_of_tasks(random):
    changed = along(EIGHT, 1, random).of("eight", "distance", 1)
    changed.columns["version"][2000:] = 2
    return [along(STRAIGHT, 1, random).of("walk_10m", "distance", 1, 2),
            along({**STRAIGHT, "length_m": 10.0}, 1, random, REMOTE, pace_m_s=0.25).of("walk_10m", "distance", 1, 3),
            there_and_back(3.2, 0.4, random).of("up_and_go", "back", 3), there_and_back(4.2, 0.6, random).of("up_and_go", "back", 4),
            there_and_back(2.8, 0.6, random).of("up_and_go", "back", 3),
            free([np.pi, np.pi], random, straight_s=14.0).of("walk_2min", "time", 40), free([], random, straight_s=70.0).of("walk_2min", "time", 60),
            free([], random, straight_s=70.0).of("walk_2min", "time", 120),
            free([np.pi], random).of("turn_180", "turn", np.pi * 0.99), free([-2 * np.pi], random).of("turn_360", "turn", np.pi * 1.99),
            free([np.pi / 2], random).of("turn_180", "turn", np.pi), along(SQUARE, 1, random).of("square", "distance", 1), changed,
            free([], random, straight_s=60.0).of("free_walk", "hand", 0), stumbles(random, 3, 60.0)[0], set_off_twice(random)]


def stumbles(random, count, seconds):
    """A steady walk with `count` sudden leans far out; the truth is their number."""
    t = np.arange(0, seconds, 0.01)
    lean = 0.055 + 0.004 * np.sin(2 * np.pi * 1.6 * t) + 0.0005 * random.standard_normal(len(t))
    at = np.linspace(8, seconds - 8, count) + random.uniform(-2, 2, count) if count else []
    for begin in at:
        size, rise, fall = random.uniform(0.075, 0.14), random.uniform(0.15, 0.35), random.uniform(0.5, 1.5)
        lean += size * np.clip(np.minimum((t - begin) / rise, 1 - (t - begin - rise) / fall), 0, 1)
    speed = ramped(seconds - 0.001, 0.4)[: len(t)]
    zero = np.zeros(len(t))
    return Walk(None, speed, zero, np.cumsum(speed) * 0.01, zero, zero, sway(len(t), 95, 0, random), USER, np.clip(lean / 0.14, -1, 1), lean), count


def set_off_twice(random):
    """The hoist follows a lean of 0.5 after 0.6 s, in half a second to 0.3 m/s, and comes to rest 0.8 s after its end."""
    t = np.arange(0, 40, 0.01)
    lean = 0.5 * (((t > 3) & (t < 15)) | ((t > 22) & (t < 33))).astype(float)
    speed = sum(0.3 * np.clip(np.minimum((t - on) / 0.5, 1 - (t - off) / 0.8), 0, 1) for on, off in ((3.6, 15), (22.6, 33)))
    zero = np.zeros(len(t))
    return Walk(None, speed, zero, np.cumsum(speed) * 0.01, zero, zero, sway(len(t), 80, 0, random), USER, lean)


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
        walks = walks_of_all_kinds(np.random.default_rng(1)) + walks_of_tasks(np.random.default_rng(5))
        database, told = recorded(walks, folder)
        for walk, one in zip(walks, told):
            exercise = json.loads(json.dumps(one["exercise"]))
            if exercise and "c_m" in exercise:
                exercise["centre_m"] = exercise.pop("c_m")
            exercise = None if exercise and exercise["shape"] == "free" else exercise
            mine = figures(columns_of(database, one["session"]), exercise, walk.task)
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


def tasks_have_their_true_results():
    random = np.random.default_rng(6)
    with tempfile.TemporaryDirectory() as folder:
        _, (ten, short, there, oval, half, wrong) = recorded(
            [along(STRAIGHT, 1, random).of("walk_10m", "distance", 1, 2), along(STRAIGHT, 0.5, random).of("walk_10m", "distance", 1, 2),
             there_and_back(3.2, 0.5, random).of("up_and_go", "back", 3), free([], random, straight_s=75.0).of("walk_2min", "time", 60),
             free([np.pi + 0.2], random).of("turn_180", "turn", np.pi), free([np.pi / 2], random).of("turn_180", "turn", np.pi)], folder)
    check(abs(ten["timed_speed_m_s"] - 0.3) < 0.003 and abs(ten["task_time_s"] - (14 / 0.3 + 2)) < 0.8, f"10 m: {ten['timed_speed_m_s']}, {ten['task_time_s']}")
    for key in ("timed_speed_m_s", "task_time_s"):
        check(short[key] is None and short["computed"][key]["reason_code"] == "task_unfinished", f"half a 10 m walk has {key} {short[key]}")
    phases = [there[key] for key in ("out_time_s", "turning_time_s", "back_time_s")]
    # A gap of 0.48 s over the first edge, 2 m along: the timed part takes 33 s.
    walk = along(STRAIGHT, 1, np.random.default_rng(6)).of("walk_10m", "distance", 1, 2)
    edge = int(np.argmax(walk.columns["x"] >= 2))
    with tempfile.TemporaryDirectory() as folder:
        database, (gapped,) = recorded([walk.cut(edge - 40, edge + 8)], folder)
        mine = figures(columns_of(database, gapped["session"]), STRAIGHT, walk.task)
    check(abs(gapped["timed_speed_m_s"] / ten["timed_speed_m_s"] - 1) < 0.003, f"with a gap {gapped['timed_speed_m_s']}")
    check(abs(gapped["timed_speed_m_s"] - mine["timed_speed_m_s"]) < 1e-7, f"with a gap {gapped['timed_speed_m_s']}, numpy {mine['timed_speed_m_s']}")
    check(abs(sum(phases) - there["task_time_s"]) < 1e-9, "the phases are the whole")
    # The turn is counted between 20 and 160 degrees, the way back ends 0.3 m before the start.
    true = 3.2 / 0.3 + 20 * DEGREE / 0.5, 140 * DEGREE / 0.5, 20 * DEGREE / 0.5 + 2.9 / 0.3
    check(max(abs(a - b) for a, b in zip(phases, true)) < 0.05, f"phases {phases} instead of {true}")
    # The lead begins half a second into the first two, in which the speed rises: 1.5 s lack half of 0.225 m/s.
    check(abs(oval["task_distance_m"] - (0.3 * 60 - 1.5 * 0.225 / 2)) < 0.01, f"60 s at 0.3 m/s: {oval['task_distance_m']} m")
    check(oval["task_time_s"] is None and oval["computed"]["task_time_s"]["reason_code"] == "no_task", "a walk of a given time has no time as result")
    check(half["task_time_s"] > 6 and wrong["task_time_s"] is None, f"turns: {half['task_time_s']}, {wrong['task_time_s']}")


def setting_off_and_stopping_are_the_true_ones():
    walk = set_off_twice(np.random.default_rng(7))
    way = np.sum(walk.columns["speed"] * 0.01)
    with tempfile.TemporaryDirectory() as folder:
        _, (one,) = recorded([walk], folder)
    late = 0.6 + 0.5 / 6
    check(abs(one["start_latency_s"] - late) <= 0.03, f"{one['start_latency_s']} s instead of {late} s")
    check(abs(one["stopping_way_m"] - 0.12) <= 0.005, f"{one['stopping_way_m']} m instead of 0.12 m")
    check(abs(one["dead_band_norm"] - (1 - 23 / 39)) < 0.01, f"dead band {one['dead_band_norm']}")
    check(abs(one["effort_s_m"] - 0.5 * 23 / way) < 0.01, f"effort {one['effort_s_m']}")


def losses_of_balance_are_found_and_not_invented():
    """Sensitivity of 0.98 at one false alarm an hour: 100 events in walks, and an hour without any."""
    random = np.random.default_rng(8)
    walks = [stumbles(random, 10, 150.0) for _ in range(10)] + [stumbles(random, 0, 600.0) for _ in range(6)]
    with tempfile.TemporaryDirectory() as folder:
        _, told = recorded([walk for walk, _ in walks], folder)
    found = [one["balance_events"] for one in told]
    print(f"  {sum(found[:10]):.0f} of 100 found, {sum(found[10:]):.0f} false in an hour")
    check(98 <= sum(found[:10]) <= 100 and sum(found[10:]) <= 1, f"found {found}")


if __name__ == "__main__":
    sys.exit(run_suite("Figures", [every_figure_is_the_one_of_its_formula, cadence_and_asymmetry_are_the_true_ones, turns_have_their_true_angles,
                                   a_pelvis_that_leads_leads_by_as_much, tasks_have_their_true_results, setting_off_and_stopping_are_the_true_ones,
                                   losses_of_balance_are_found_and_not_invented]))
