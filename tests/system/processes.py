"""Programs that die, hang and starve (hazards H5, H21, H22, H23, H26): what the wheels do, on the bus and in the simulator's own time.

The simulator goes by its own time and simply lets go of what a busy machine does not give it, so a stop without a core is measured there and
means the same on any machine. A stop that the core makes itself is read from its own recording of the bus; when the machine held the core
up meanwhile (a gap between two SYNCs), the measurement means nothing and is made again.
"""
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

from driver import Driver
from harness import Failed, Hoist, Skipped, check, check_safe, run, run_hoist, until

BIN = sys.argv[1]
TOP = sys.argv[2]
hoist = None

GIVES_UP_S = 0.050 + 0.001  # after the last command: the drive's own deadline, and one cycle of its servo
QUICK_STOP_M_S2 = 1.0
RELAY_S = 0.95  # the motors' relay opens no earlier after the last command: its feed was at most 50 ms older
SERVER_GONE_S = 0.270  # H21: until the core brakes
STARVED_S = 0.025  # between two SYNCs: the machine did not let the core run
SYNC, ANSWERS = 0x080, (0x181, 0x182)  # ids: everybody's beat, and what both drives say to each
UNDER_WAY_S = 0.05  # what a server has said before it was gone has reached the core by then


def again():
    """What every case begins with, and so what every case leaves must allow: all three programs run, standing, ready, at the start mark."""
    if hoist.sim.process.poll() is not None:
        hoist.start_sim()
    if hoist.core.process.poll() is not None:
        hoist.start_core()
    if hoist.server.process.poll() is not None:
        hoist.start_server()
    hoist.recover()
    hoist.place_anew()


def signal_to(program, number):
    program.process.send_signal(number)


def witness():
    return hoist.ask_sim(op="witness")


def wheels_stop_by_themselves(relay_opens=True):
    """Commands are missing: both drives time out, brake evenly and stop; later the relay opens."""

    def longest_s(one):
        return GIVES_UP_S + abs(one["speed_m_s"]) / QUICK_STOP_M_S2 + 0.15

    def over():
        # A wheel may be at rest while its drive still rightly obeys, and one that never comes to rest must not be waited for.
        now = witness()
        for one in (now["left"], now["right"]):
            silent_s = now["time_s"] - one["command_s"]
            if silent_s <= GIVES_UP_S + 0.01 or (one["at_rest_s"] is None and silent_s <= longest_s(one)):
                return None
        return now

    seen = until("the wheels had time to stand", over, 30.0, 0.05)
    for side in ("left", "right"):
        one = seen[side]
        check_safe(one["gave_up_s"] is not None, f"the {side} drive still obeys: {one}")
        check_safe(one["at_rest_s"] is not None, f"the {side} wheel still turns: {one}, now {seen['time_s']:.3f} s")
        gave_up_s, at_rest_s = one["gave_up_s"] - one["command_s"], one["at_rest_s"] - one["command_s"]
        check_safe(gave_up_s <= GIVES_UP_S, f"the {side} drive gave up {gave_up_s:.4f} s after its last command")
        check_safe(at_rest_s <= longest_s(one), f"the {side} wheel stood {at_rest_s:.3f} s after its last command, from {one['speed_m_s']:.2f} m/s")
        print(f"         {side}: {one['speed_m_s']:.2f} m/s, gave up {gave_up_s * 1e3:.0f} ms after the last command, stood after {at_rest_s * 1e3:.0f} ms, "
              f"rolled {one['rolled_m'] * 100:.0f} cm")
    if relay_opens:
        last_s = max(seen[side]["command_s"] for side in ("left", "right"))
        until("the relay opens", lambda: not witness()["relay_closed"], 20.0, 0.02)
        opened_s = witness()["time_s"] - last_s
        # Not in simulated time alone: the last feed is older when the core was delayed just before it ended.
        check(opened_s >= RELAY_S, f"the relay opened after {opened_s:.2f} s, before the drives are sure to stand")


def never_moves_by_itself(seconds=2.0):
    """Nothing turns until a person requests it."""
    start = hoist.truth()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        now = hoist.truth()
        check_safe(abs(now["speed_m_s"]) < 0.02, f"it moves at {now['speed_m_s']:.3f} m/s")
        time.sleep(0.05)
    now = hoist.truth()
    moved_m = abs(now["x_m"] - start["x_m"]) + abs(now["y_m"] - start["y_m"])
    check_safe(moved_m < 0.02, f"it moved {moved_m:.3f} m")


def goes_on_walking(metres=0.4):
    """Read from the simulator, because no program may be able to report the mode."""
    before = hoist.truth()["x_m"]
    until("it goes on walking", lambda: abs(hoist.truth()["x_m"] - before) > metres, 30.0)
    seen = witness()
    for side in ("left", "right"):
        check(seen[side]["gave_up_s"] is None, f"the {side} drive stopped obeying: {seen}")


def h5_a_killed_core_leaves_wheels_that_stop_and_comes_back_in_init():
    again()
    hoist.walk()
    signal_to(hoist.core, signal.SIGKILL)
    hoist.core.process.wait(10)
    wheels_stop_by_themselves()
    never_moves_by_itself(0.5)
    hoist.start_core()
    never_moves_by_itself()
    until("it is not walking", lambda: hoist.mode() in ("init", "standby"), 30.0)
    again()
    check(witness()["relay_closed"], "the relay is closed again")
    hoist.walk(0.2)


def h22_a_stopped_core_that_goes_on_stands_and_stays_so():
    again()
    hoist.walk()
    signal_to(hoist.core, signal.SIGSTOP)
    try:
        wheels_stop_by_themselves()
    finally:
        signal_to(hoist.core, signal.SIGCONT)
    never_moves_by_itself()
    check(hoist.mode() in ("init", "protective_stop", "fault", "emergency_stop"), f"mode {hoist.mode()} after two seconds of silence")
    check(hoist.status()["blocked"] != [], "and nothing may start before an acknowledgement")


def h5_a_cut_line_stops_the_wheels_and_a_mended_one_moves_nothing():
    again()
    hoist.walk()
    hoist.ask_sim(op="line", cut=True)
    try:
        wheels_stop_by_themselves()
        until("the core knows", lambda: hoist.mode() == "protective_stop", 10.0)
    finally:
        hoist.ask_sim(op="line", cut=False)
    never_moves_by_itself()
    check(hoist.mode() == "protective_stop", f"mode {hoist.mode()}: it waits for a person")


def gap_since(begin_s, *identifiers):
    """For longer than STARVED_S the recording has none of these."""
    recorded_until(time.monotonic())
    times = [at_s for at_s, identifier, _ in frames_since(begin_s) if identifier in identifiers]
    return any(after - before > STARVED_S for before, after in zip(times, times[1:]))


def held_up_since(begin_s):
    """The machine did not let the core run in its time, as the core's own recording shows."""
    return gap_since(begin_s, SYNC)


def line_held_up_since(begin_s):
    """The core has sent every SYNC in time, but neither drive's answers came: the machine kept back what was written to the line. Between the
    terminal of the simulator and the core an ordinary thread of the kernel carries it, however high the priority of both."""
    return gap_since(begin_s, *ANSWERS)


def h21_a_server_that_dies_or_hangs_does_not_disturb_a_walk():
    for _ in range(3):
        begin_s = time.monotonic()
        try:
            walks_without_a_server()
            return
        except Failed:
            if not held_up_since(begin_s):
                raise
            if hoist.server.process.poll() is not None:
                hoist.start_server()
    raise Skipped("this machine is too busy: the core itself was delayed each time")


def walks_without_a_server():
    again()
    hoist.walk()
    signal_to(hoist.server, signal.SIGSTOP)
    try:
        goes_on_walking()
    finally:
        signal_to(hoist.server, signal.SIGCONT)
    goes_on_walking(0.2)
    signal_to(hoist.server, signal.SIGKILL)
    hoist.server.process.wait(10)
    goes_on_walking()
    hoist.start_server()
    until("the new server finds it walking", lambda: hoist.status()["connected"] and hoist.mode() == "user", 20.0)
    goes_on_walking(0.2)


def drive_remotely():
    driver = Driver(hoist.port, hoist.token)
    try:
        driver.start()
        driver.hold(0.6)
        until("it drives", lambda: hoist.truth()["speed_m_s"] > 0.15, 10.0, 0.02)
    except Failed:
        driver.close()
        raise
    return driver


def frames_since(begin_s, offset=None):
    """What the core that runs now heard and said since then, from its own recording: (time, id, data), times on the steady clock. Setting the
    time of day changes nothing: the core looks at it once, at its start. `offset`: where in the file to begin to read."""
    with open(hoist.recording, "rb") as file:
        file.seek(max(hoist.recording_begin, offset or 0))
        for line in file:
            if not line.endswith(b"\n"):
                return  # still being written
            match = re.match(rb"\((\d+\.\d+)\) \S+ ([0-9A-F]+)#((?:[0-9A-F]{2})*)", line)
            if match:
                at_s = float(match.group(1)) - hoist.utc_offset_s
                if at_s >= begin_s:
                    yield at_s, int(match.group(2), 16), bytes.fromhex(match.group(3).decode())


def recorded_until(end_s):
    """The recording is written by a thread of no priority, whenever it is let: what it does not hold yet has not failed to happen."""

    def ask():
        tail = os.path.getsize(hoist.recording) - 4096
        return any(identifier == SYNC for _, identifier, _ in frames_since(end_s, tail))

    if hoist.core.process.poll() is None:
        until("the recording has come so far", ask)


def brakes_within(gone_s, surely_gone_s, limit_s):
    """The commanded speed falls and never rises again after `gone_s`; gives when it began to fall. None when the machine was too busy."""
    last_s, target, began_s, stands = gone_s, None, None, False
    for at_s, identifier, data in frames_since(gone_s - 0.1):
        if identifier == SYNC:
            if at_s - last_s > STARVED_S and last_s > gone_s - 0.1:
                return None
            last_s = at_s
        if identifier != 0x201 or len(data) != 6:
            continue
        now = abs(int.from_bytes(data[2:6], "little", signed=True))
        if at_s > gone_s and target is not None:
            if began_s is None and now < target * 0.998:
                began_s = at_s
            if began_s is not None:
                # A delayed client has made the core brake before; the last command may then still be under way.
                check(now <= target or at_s - surely_gone_s > UNDER_WAY_S, "the command fell and rose again while the server went")
                check_safe(now <= target, f"the command rose again from {target} to {now}, {at_s - gone_s:.3f} s after the server was gone")
            stands = now == 0
        target = now
    check_safe(began_s is not None, "the core never braked")
    check_safe(stands, "the command did not come to zero")
    check_safe(began_s - surely_gone_s <= limit_s, f"the core braked {began_s - surely_gone_s:.3f} s after the server was gone")
    return began_s - surely_gone_s


def server_gone_in_remote(number):
    problem = None
    for _ in range(4):
        again()
        try:
            driver = drive_remotely()
        except (Failed, OSError) as error:  # a hand delayed by a quarter of a second stops the hoist, and presses again
            problem = error
            continue
        try:
            gone_s = time.monotonic()
            signal_to(hoist.server, number)
            surely_gone_s = time.monotonic()
            held_up = surely_gone_s - gone_s > STARVED_S  # this test was: the server went on longer than it believes
            until("the machine stands", lambda: abs(hoist.truth()["speed_m_s"]) < 0.01, 20.0)
            recorded_until(time.monotonic() + 0.3)
        finally:
            driver.close()
            if number == signal.SIGSTOP:
                signal_to(hoist.server, signal.SIGCONT)
            else:
                hoist.server.process.wait(10)
                hoist.start_server()
        began_s = None
        try:
            began_s = None if held_up else brakes_within(gone_s, surely_gone_s, SERVER_GONE_S)
        except Failed as error:
            problem = error
        never_moves_by_itself(1.0)
        if began_s is not None:
            print(f"         the core began to brake {began_s * 1e3:.0f} ms after the server was gone")
            return
    if problem is not None:
        raise Failed(f"in one of four tries: {problem!r}")
    raise Skipped("this machine is too busy to measure a quarter of a second")


def h21_a_hanging_server_ends_remote_driving_in_time():
    server_gone_in_remote(signal.SIGSTOP)


def h21_a_killed_server_ends_remote_driving_in_time():
    server_gone_in_remote(signal.SIGKILL)


def h23_core_and_server_die_together_and_start_together():
    again()
    hoist.walk()
    signal_to(hoist.server, signal.SIGKILL)
    signal_to(hoist.core, signal.SIGKILL)
    hoist.server.process.wait(10)
    hoist.core.process.wait(10)
    wheels_stop_by_themselves(relay_opens=False)
    hoist.start_core()
    hoist.start_server()
    never_moves_by_itself()


def h5_everything_behind_the_gateway_dies_and_comes_back():
    again()
    hoist.walk()
    signal_to(hoist.sim, signal.SIGKILL)
    hoist.sim.process.wait(10)
    until("the core stops", lambda: hoist.mode() == "protective_stop", 10.0)
    until("the core knows why", lambda: "bus_down" in hoist.status()["faults"], 10.0)
    hoist.start_sim()
    never_moves_by_itself()
    again()
    hoist.walk(0.2)
    # A pause of the whole machine behind the gateway: no frames for a second.
    signal_to(hoist.sim, signal.SIGSTOP)
    try:
        until("the core stops", lambda: hoist.mode() == "protective_stop", 10.0)
    finally:
        signal_to(hoist.sim, signal.SIGCONT)
    hoist.wait_stopped()
    never_moves_by_itself(1.0)


def h22_a_machine_under_load_walks_on_or_stands_but_never_runs_away():
    for _ in range(3):
        if walks_under_load():
            return
    raise Skipped("this machine is too busy: the core or the line was delayed each time")


def walks_under_load():
    """Whether something can be said about this machine."""
    again()
    hoist.walk()
    granted = hoist.call("GET", "/loop")[1]["priority"] is not None
    begin_s = time.monotonic()
    load = [subprocess.Popen([sys.executable, "-c", "while True: sum(range(10000))"]) for _ in range(2 * (os.cpu_count() or 1))]
    try:
        fastest, stopped, end = 0.0, None, time.monotonic() + 4.0
        while time.monotonic() < end:
            fastest = max(fastest, abs(hoist.truth()["speed_m_s"]))
            # Polled without pause: each command restarts the witness's record, also one that tells a drive to stay off.
            seen = witness()
            if any(seen[side]["gave_up_s"] is not None for side in ("left", "right")):
                stopped = seen
            time.sleep(0.05)
    finally:
        for one in load:
            one.kill()
            one.wait()
    check(fastest < 0.7, f"{fastest:.2f} m/s under load")
    check(hoist.core.process.poll() is None and hoist.server.process.poll() is None, "a program has ended")
    if stopped is None:
        print("         it walked on beside two busy programs for each core")
        return True
    # With its priority the core does not notice other programs, however many.
    if granted and not held_up_since(begin_s):
        check(line_held_up_since(begin_s), f"it stopped for ordinary programs: {stopped}")
    return not granted


def loop_timing():
    code, loop = hoist.call("GET", "/loop")
    check(code == 200, f"{code} {loop}")
    return loop


def h22_with_what_it_asks_for_the_loop_never_waits_for_memory():
    again()
    hoist.walk(0.2)
    time.sleep(2.0)
    loop = loop_timing()
    check(loop["steps"] > 100 and sum(row["count"] for row in loop["ever"]) == loop["steps"], f"{loop}")
    check(loop["allocations"] == 0, f"{loop['allocations']} requests for memory in the control thread")
    print(f"         priority {loop['priority']}, core {loop['cpu']}; lateness {loop['lateness_p50_s'] * 1e6:.0f} us, 99 % {loop['lateness_p99_s'] * 1e6:.0f} us, "
          f"latest {loop['lateness_max_s'] * 1e6:.0f} us; {loop['page_faults']} page faults")
    if not loop["memory_locked"]:
        raise Skipped("this machine does not let a program lock its memory")
    # The kernel may move locked pages, which costs a page fault now and then. A loop that waits for memory has them all
    # the time.
    counts = [loop["page_faults"]]
    while counts[-1] not in [0] + counts[:-1] and len(counts) < 4:
        again()
        hoist.walk(0.2)
        time.sleep(2.0)
        counts.append(loop_timing()["page_faults"])
    check(counts[-1] in [0] + counts[:-1], f"page faults in the control thread, walk after walk: {counts}")


def thread_states(pid):
    for thread in os.listdir(f"/proc/{pid}/task"):
        try:
            with open(f"/proc/{pid}/task/{thread}/stat") as file:
                yield file.read().rpartition(")")[2].split()[0]
        except OSError:
            yield "gone"


def h23_the_service_manager_hears_ready_and_a_sign_of_life_only_while_steps_go_on():
    folder = tempfile.mkdtemp(prefix="hoist-")
    path = os.path.join(folder, "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(path)
        manager.settimeout(20)
        environment = dict(os.environ, NOTIFY_SOCKET=path, WATCHDOG_USEC="500000")
        core = subprocess.Popen([os.path.join(BIN, "hoist-control"), "--bus", f"slcan:{folder}/nothing", "--socket", f"{folder}/core.sock", "--no-realtime"],
                                env=environment, stdout=subprocess.DEVNULL)
        try:
            check(manager.recv(200) == b"READY=1\nWATCHDOG=1", "ready comes first, with the first steps")
            for _ in range(5):
                check(manager.recv(200) == b"WATCHDOG=1", "a sign of life")
            core.send_signal(signal.SIGSTOP)
            until("all of it is stopped", lambda: set(thread_states(core.pid)) == {"T"}, 10.0, 0.01)
            manager.setblocking(False)
            try:
                while True:
                    manager.recv(200)
            except BlockingIOError:
                pass
            time.sleep(0.6)
            try:
                check(False, f"a stopped core says {manager.recv(200)}")
            except BlockingIOError:
                pass
            core.send_signal(signal.SIGCONT)
            manager.settimeout(20)
            check(manager.recv(200) == b"WATCHDOG=1", "and again")
            core.send_signal(signal.SIGTERM)
            last = b""
            while last != b"STOPPING=1":
                last = manager.recv(200)
            check(core.wait(20) == 0, "exit code")
        finally:
            if core.poll() is None:
                core.kill()
                core.wait()
            shutil.rmtree(folder)


def the_service_file_is_sound():
    if shutil.which("systemd-analyze") is None:
        raise Skipped("systemd-analyze is not installed")
    folder = tempfile.mkdtemp(prefix="hoist-")
    try:
        for name in sorted(os.listdir(os.path.join(TOP, "deploy/systemd"))):
            with open(os.path.join(TOP, "deploy/systemd", name)) as file:
                # The program's place on an installed hoist; here it need not be.
                text = re.sub(r"/usr/bin/hoist-\w+", "/bin/true", file.read())
            with open(os.path.join(folder, name), "w") as file:
                file.write(text)
            said = run("systemd-analyze", "verify", os.path.join(folder, name))
            check(said.strip() == "", f"{name}: {said}")
            run("systemd-analyze", "security", "--offline=true", "--threshold=15", os.path.join(folder, name))
    finally:
        shutil.rmtree(folder)


def main():
    global hoist
    hoist = Hoist(BIN, None, None)
    hoist.recording = hoist.path("bus.log")
    hoist.real_time = True  # as on a hoist, where this machine permits it
    return run_hoist("Processes", hoist, [
        the_service_file_is_sound,
        h23_the_service_manager_hears_ready_and_a_sign_of_life_only_while_steps_go_on,
        h5_a_killed_core_leaves_wheels_that_stop_and_comes_back_in_init,
        h22_a_stopped_core_that_goes_on_stands_and_stays_so,
        h5_a_cut_line_stops_the_wheels_and_a_mended_one_moves_nothing,
        h21_a_server_that_dies_or_hangs_does_not_disturb_a_walk,
        h21_a_hanging_server_ends_remote_driving_in_time,
        h21_a_killed_server_ends_remote_driving_in_time,
        h23_core_and_server_die_together_and_start_together,
        h5_everything_behind_the_gateway_dies_and_comes_back,
        h22_a_machine_under_load_walks_on_or_stands_but_never_runs_away,
        h22_with_what_it_asks_for_the_loop_never_waits_for_memory,
    ])


if __name__ == "__main__":
    sys.exit(main())
