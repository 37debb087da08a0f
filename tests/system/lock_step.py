"""Lock-step: simulator and core on one clock. A busy computer is played by stopping one program for 0.3 s again and again: in lock-step the
walk goes on and simulated time is slow; by the wall clock the same ends the walk. Partners that die are noticed, and come back."""
import json
import math
import os
import signal
import subprocess
import sys
import time

from harness import Failed, Hoist, Skipped, check, check_safe, run_hoist, until

BIN = sys.argv[1]
HELD_S = 0.3  # ten times what a real hoist allows
hoist = None


def starve(program, seconds=HELD_S):
    program.process.send_signal(signal.SIGSTOP)
    time.sleep(seconds)
    program.process.send_signal(signal.SIGCONT)
    time.sleep(0.2)


def again():
    hoist.recover()
    hoist.place_anew()


def walks(metres):
    before_m = hoist.truth()["x_m"]
    until("it walks on", lambda: abs(hoist.truth()["x_m"] - before_m) > metres, 60.0)
    status = hoist.status()
    check(status["mode"] == "user", f"it walks in {status['mode']}: {status['faults']}")


def notices():
    return {one["name"]: one["text"]["en"] for one in hoist.call("GET", "/status")[1]["notices"]}


def a_starved_pair_walks_on_and_the_screen_says_that_time_is_slow():
    again()
    hoist.walk()
    before, told = hoist.status()["tick"], ""
    for index in range(16):
        starve(hoist.sim if index % 2 else hoist.core)
        told = notices().get("simulation_slow", told)
    status = hoist.status()
    check(status["mode"] == "user" and status["connected"], f"the walk ended: {status}")
    check(status["tick"] > before, "steps go on")
    check("simulated time runs at" in told and "{" not in told, f"the notice: {told!r}")
    walks(0.2)
    until("the notice goes with its cause", lambda: "simulation_slow" not in notices(), 60.0)


def a_core_that_dies_leaves_wheels_that_stop_and_comes_back_in_init():
    again()
    hoist.walk()
    hoist.core.process.send_signal(signal.SIGKILL)
    hoist.core.process.wait(10)
    until("the drives are off", lambda: not hoist.truth()["enabled"], 20.0)
    before_s = hoist.truth()["time_s"]
    until("time goes on without a core", lambda: hoist.truth()["time_s"] > before_s + 0.5, 20.0)
    hoist.start_core()
    until("it stands", lambda: hoist.mode() in ("init", "standby"), 30.0)
    check_safe(abs(hoist.truth()["speed_m_s"]) < 0.02, "a new core moves nothing by itself")
    again()
    hoist.walk(0.2)


def a_simulator_that_dies_is_a_dead_bus_and_comes_back():
    again()
    hoist.walk()
    said = hoist.core.said()
    hoist.sim.end(signal.SIGKILL)
    hoist.core.says("bus: the", behind=said)
    until("the core stops by its own time", lambda: hoist.mode() in ("protective_stop", "fault"), 30.0)
    hoist.start_sim()
    hoist.core.says("bus: up", behind=said)
    until("the new drives hold", lambda: hoist.truth()["enabled"], 30.0)
    stays_until_acknowledged(2.0)
    again()
    hoist.walk(0.2)


def stays_until_acknowledged(seconds):
    """PROTECTIVE_STOP holds with the drives enabled, while the patient leans as if he led: for so long of simulated time nothing moves."""
    begin = now = hoist.truth()
    while now["time_s"] < begin["time_s"] + seconds:
        check_safe(hoist.mode() == "protective_stop", f"nobody has acknowledged: {hoist.status()}")
        now = hoist.truth()
        moved_m = math.hypot(now["x_m"] - begin["x_m"], now["y_m"] - begin["y_m"])
        check_safe(moved_m < 0.01 and abs(now["speed_m_s"]) < 0.02, f"it moved without an acknowledgement: {now}")


def partners_that_hang_are_let_go():
    again()
    hoist.walk()
    said = hoist.sim.said()
    hoist.core.process.send_signal(signal.SIGSTOP)
    try:
        hoist.sim.says("does not answer", behind=said)
        until("the drives are off", lambda: not hoist.truth()["enabled"], 20.0)
    finally:
        hoist.core.process.send_signal(signal.SIGCONT)
    again()
    hoist.walk(0.2)
    said = hoist.core.said()
    hoist.sim.process.send_signal(signal.SIGSTOP)
    try:
        hoist.core.says("bus: ", behind=said)
        until("the core says so", lambda: hoist.mode() in ("protective_stop", "fault"), 30.0)
    finally:
        hoist.sim.process.send_signal(signal.SIGCONT)
    again()
    hoist.walk(0.2)


def sessions():
    """Of the database, newest first."""
    done = subprocess.run([os.path.join(BIN, "hoist"), "sessions", hoist.path("hoist.db")], capture_output=True, text=True, timeout=60, check=False)
    check(done.returncode == 0, f"hoist sessions: {done.stderr}")
    return [json.loads(line) for line in done.stdout.splitlines()]


def walk_to_the_end(metres):
    """Walks and stops; gives the session when the recorder has closed it."""
    before = {one["id"] for one in sessions()}
    hoist.walk(metres)
    hoist.call("POST", "/stop", {})

    def closed():
        newest = [one for one in sessions() if one["id"] not in before]
        return newest[0] if newest and not any(one["recording"] for one in newest) else None

    return until("the recorder closes the session", closed, 60.0, 0.3)


def run_again(verb, session, *options):
    done = subprocess.run([os.path.join(BIN, "hoist"), verb, hoist.path("hoist.db"), str(session["id"]), *options], capture_output=True,
                          text=True, timeout=120, check=False)
    return done.returncode, done.stdout + done.stderr


def check_the_same_bits(session):
    code, said = run_again("verify", session)
    print(said, end="", flush=True)
    check_safe(", 0 differ" in said, f"a session run again is another one: {said}")
    check(code == 0, f"hoist verify of session {session}: {code}, {said}")


def a_recorded_walk_run_again_gives_the_same_bits():
    again()
    session = walk_to_the_end(1.0)
    check_the_same_bits(session)
    code, said = run_again("replay", session, "--set", "speed_cap_norm=0.3")
    check(code == 0 and "wheel_left_command_m_s" in said, f"hoist replay with half the speed: {code}, {said}")


def every_session_of_cut_off_programs_run_again_is_the_same():
    """Of sessions in which core or simulator were killed or held, what can be run again is the same, and the rest is named."""
    all_of_them = sessions()
    check(len(all_of_them) >= 3, f"the cases before have recorded: {all_of_them}")
    for session in all_of_them:
        if session["recording"] or session["samples"] == 0:
            continue
        code, said = run_again("verify", session)
        check_safe(", 0 differ" in said, f"session {session['id']} run again is another one: {said}")
        check(code == 0 or (code == 3 and "not run again: ticks" in said), f"hoist verify of session {session['id']}: {code}, {said}")


def what_knows_real_time_only_is_refused():
    line = hoist.path("refused.sock")
    for program, arguments, named in (
            ("hoist-control", ["--bus", f"sim:{line}", "--inputs", "pokeys:usb"], "--inputs pokeys:usb"),
            ("hoist-control", ["--bus", "sim:"], "1 to 107 characters"),
            ("hoist-control", ["--bus", "sim:/" + 107 * "x"], "1 to 107 characters"),
            ("hoist-sim", ["--lock-step", line, "--pty-link", hoist.path("refused")], "--lock-step: not with"),
            ("hoist-sim", ["--lock-step", line, "--bus", "socketcan:vcan0"], "--lock-step: not with"),
            ("hoist-sim", ["--lock-step", line, "--pokeys-udp", "20055"], "--lock-step: not with")):
        done = subprocess.run([os.path.join(BIN, program), *arguments], capture_output=True, text=True, timeout=20, check=False)
        check(done.returncode == 2 and named in done.stderr, f"{program} {arguments}: {done.returncode}, {done.stderr!r}")
    check(not os.path.exists(line), "a refused simulator makes no socket")


def in_real_time(walk):
    """What `walk` gives. By the wall clock a machine that holds up the core for 0.2 s ends any walk, as it must; the core says so itself."""
    for _ in range(4):
        again()
        try:
            return walk()
        except Failed:
            if "loop_overrun" not in hoist.status()["faults"]:
                raise
    raise Skipped("this machine is too busy: the core itself was held up for 0.2 s each time")


def by_the_wall_clock_the_same_ends_the_walk():
    hoist.stop()
    hoist.lock_step = False
    hoist.start()
    check_the_same_bits(in_real_time(lambda: walk_to_the_end(0.5)))
    in_real_time(hoist.walk)
    for program in (hoist.sim, hoist.core):
        starve(program)
    until("real time is real time: the walk ends", lambda: hoist.mode() != "user", 10.0)
    check("simulation_slow" not in notices(), "the steady clock is never slow")


def main():
    global hoist
    hoist = Hoist(BIN, None, None)
    hoist.lock_step = True
    return run_hoist("LockStep", hoist, [
        a_starved_pair_walks_on_and_the_screen_says_that_time_is_slow,
        a_core_that_dies_leaves_wheels_that_stop_and_comes_back_in_init,
        a_simulator_that_dies_is_a_dead_bus_and_comes_back,
        partners_that_hang_are_let_go,
        a_recorded_walk_run_again_gives_the_same_bits,
        every_session_of_cut_off_programs_run_again_is_the_same,
        what_knows_real_time_only_is_refused,
        by_the_wall_clock_the_same_ends_the_walk,
    ])


if __name__ == "__main__":
    sys.exit(main())
