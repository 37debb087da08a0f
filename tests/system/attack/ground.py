"""The hoist that is attacked, what must hold after each attack, and the table of how each went."""
import contextlib
import os
import re
import signal
import sqlite3
import sys
import threading
import time
import traceback

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from harness import Failed, Hoist, Skipped, Unsafe, check, check_safe, until  # noqa: E402
from wire import Line, WebSocket, ask  # noqa: E402

ATTACKS = []
TRIES = 2
STOP_S = 2.0  # from STOP to both wheels at rest: 0.65 m/s at 0.5 m/s2, and the way there
FASTEST_M_S = 0.9  # of the simulated patient and of the driving limit, with room

# What a computer that is too busy for the programs does to a walk; an attack on the network must not, so it is tried again first.
MACHINE_FAULTS = {"loop_overrun", "bus_down", "drive_left_lost", "drive_right_lost", "tilt_left_lost", "tilt_right_lost", "tilt_base_lost", "io_lost",
                  "server_lost"}


def attack(leaves):
    """Registers an attack. `leaves` says in which state it is made and what must be true afterwards: "walking" goes on walking, "stopped" has
    come to rest from walking or driving, "standby" is made while the hoist stands."""

    def register(function):
        ATTACKS.append((function, leaves))
        return function

    return register


def beside(count, function):
    """Starts threads that call function(number) during the attack, at low priority: an attacker has a separate computer."""

    def yielding(number):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), 19)
        function(number)

    threads = [threading.Thread(target=yielding, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    return threads


class Busy(Failed):
    """The walk ended for a reason that a busy computer can cause."""


class Ground:
    def __init__(self, bin_folder):
        self.hoist = Hoist(bin_folder, None, None, scenario="figure-eight")
        self.hoist.core_options = ["--params", self.hoist.path("parameters.json")]
        self.hoist.real_time = True  # as on a hoist, where this machine permits it
        self.noted = ""

    def note(self, figures):
        """Stands in the table behind an attack that passed."""
        self.noted = figures

    # Short names for the attacks.
    @property
    def port(self):
        return self.hoist.port

    @property
    def bearer(self):
        return ("Authorization", f"Bearer {self.hoist.token}")

    @property
    def json_type(self):
        return ("Content-Type", "application/json")

    def ask(self, method, target, headers=(), body=b"", host=None):
        return ask(self.port, method, target, headers, body, host)

    def live(self, **options):
        socket = WebSocket(self.port, [self.bearer], **options)
        check(socket.status == 101, f"the WebSocket's handshake was answered {socket.status}")
        return socket

    def cookie(self):
        """Uses the newest one-time link as a browser does."""
        link = re.findall(r"/\?token=([0-9a-f]+)", self.hoist.server.output())[-1]
        with Line(self.port) as line:
            line.send(f"GET /?token={link} HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nConnection: close\r\n\r\n".encode())
            found = re.search(rb"Set-Cookie: (hoist_session=[0-9a-f]+)", line.read_all())
        check(found, "the link gave no cookie")
        return link, ("Cookie", found.group(1).decode())

    def start_sim(self):
        """A machine's nodes do not share a processor with the network: the simulator goes before server and attackers, where permitted."""
        self.hoist.start_sim()
        pid = self.hoist.sim.process.pid
        with contextlib.suppress(PermissionError):
            for thread in os.listdir(f"/proc/{pid}/task"):
                os.sched_setscheduler(int(thread), os.SCHED_FIFO, os.sched_param(10))

    def start(self):
        self.start_sim()
        self.hoist.start_core()
        self.hoist.start_server()
        self.hoist.recover()

    # States.
    def ready(self):
        """Everything runs and the hoist stands in standby at the start mark."""
        hoist = self.hoist
        for program, start in (("sim", self.start_sim), ("core", hoist.start_core), ("server", hoist.start_server)):
            if getattr(hoist, program).process.poll() is not None:
                start()
        hoist.recover()
        hoist.place_anew()

    def walk(self):
        self.ready()
        self.hoist.walk(0.1)

    def walks_on(self):
        """The patient leads and the machine moves. Read from the simulator, so that it works without a server too."""
        begin = self.hoist.truth()

        def moved():
            now = self.hoist.truth()
            check_safe(abs(now["speed_m_s"]) < FASTEST_M_S, f"it runs at {now['speed_m_s']:.2f} m/s")
            return now["enabled"] and abs(now["x_m"] - begin["x_m"]) + abs(now["y_m"] - begin["y_m"]) > 0.03

        try:
            until("the hoist walks on", moved, 5.0, 0.1)
        except Failed as error:
            status = self.hoist.status()
            if set(status["faults"]) & MACHINE_FAULTS:
                raise Busy(f"the walk ended: {status['faults']}") from None
            raise Failed(f"{error}; {status}") from None

    def stands(self, within_s=STOP_S):
        """At rest in time, and nothing turns again."""
        end = time.monotonic() + within_s
        while abs(self.hoist.truth()["speed_m_s"]) > 0.01:
            check_safe(time.monotonic() < end + 1.0, f"it still moves {within_s + 1.0:.0f} s later: {self.hoist.truth()}")
            time.sleep(0.02)
        place = self.hoist.truth()
        end = time.monotonic() + 0.5
        while time.monotonic() < end:
            now = self.hoist.truth()
            moved_m = abs(now["x_m"] - place["x_m"]) + abs(now["y_m"] - place["y_m"])
            check_safe(abs(now["speed_m_s"]) < 0.02 and moved_m < 0.02, f"it moves again by itself: {now}")
            time.sleep(0.05)

    # After each attack.
    def aftermath(self, leaves):
        hoist = self.hoist
        for program in (hoist.sim, hoist.core, hoist.server):
            code = program.process.poll()
            check_safe(code is None, f"{program.name} has died ({code})")
        began = time.monotonic()
        check(self.ask("GET", "/api/v1/status", [self.bearer]) == 200, "the server does not answer GET /status")
        check(time.monotonic() - began < 2.0, f"GET /status took {time.monotonic() - began:.1f} s")
        if leaves == "walking":
            self.walks_on()
        elif leaves == "stopped":
            self.stands()
        else:
            check_safe(abs(hoist.truth()["speed_m_s"]) < 0.02, "it moves, and nobody asked for it")
        self.database_is_whole()
        check(self.ask("POST", "/api/v1/stop", [self.bearer]) == 200, "STOP was not taken")
        self.stands()
        until("the core has stopped", lambda: hoist.mode() in ("protective_stop", "fault", "emergency_stop"), 2.0, 0.05)

    def database_is_whole(self):
        with contextlib.closing(sqlite3.connect(f"file:{self.hoist.path('hoist.db')}?mode=ro", uri=True, timeout=10)) as database:
            found = database.execute("PRAGMA integrity_check").fetchall()
            check(found == [("ok",)], f"the database is damaged: {found[:3]}")


def outcome_of(ground, function, leaves):
    """One attack and what it left: (result, reason)."""
    first = ""
    for attempt in range(TRIES):
        last = attempt + 1 == TRIES
        try:
            if leaves == "walking":
                ground.walk()
            else:
                ground.ready()
            ground.note("")
            function(ground)
            ground.aftermath(leaves)
            return "passed", "; ".join(filter(None, [ground.noted, f"in its second try; first: {first}" if first else ""]))
        except Unsafe as error:
            return "failed", f"UNSAFE: {error}"
        except Skipped as reason:
            return "skipped", str(reason)
        except Exception as error:  # pylint: disable=broad-except
            # Real programs in real time: a delayed machine proves nothing; a real error fails twice.
            if last and not isinstance(error, Failed):
                traceback.print_exc()
            if last and isinstance(error, Busy):
                return "skipped", f"this machine is too busy: {error}"
            if last:
                return "failed", str(error) or repr(error)
            first = str(error) or repr(error)
    raise AssertionError


def run(ground, only, seconds):
    """Every attack in turn; gives the exit code. None begins after `seconds`, and everything ends by an alarm if one hangs."""
    signal.signal(signal.SIGALRM, lambda *_: (_ for _ in ()).throw(SystemExit("attack: not over in time, ended by the alarm")))
    signal.alarm(int(seconds + 120))
    counts = {"passed": 0, "failed": 0, "skipped": 0}
    rows, end = [], time.monotonic() + seconds
    try:
        ground.start()
        for function, leaves in ATTACKS:
            if only and not re.search(only, function.__name__):
                continue
            began = time.monotonic()
            if began > end:
                result, reason = "skipped", f"no time left (--minutes {seconds / 60:.0f})"
            else:
                result, reason = outcome_of(ground, function, leaves)
            counts[result] += 1
            name = function.__name__.replace("_", " ")
            rows.append(f"{result if result != 'failed' else 'FAILED':8} {time.monotonic() - began:5.1f} s  {leaves:8} {name}")
            print(rows[-1] + (f"\n{'':27}{reason[:400]}" if reason else ""), flush=True)
    finally:
        signal.alarm(0)
        if counts["failed"] or not rows:
            print(ground.hoist.logs()[-4000:])
        try:
            ground.hoist.stop()
        except Failed as error:
            counts["failed"] += 1
            print(f"FAILED   a program does not end: {error}")
    if not counts["failed"]:
        ground.hoist.forget()
    else:
        print(f"what the programs wrote stays in {ground.hoist.folder}")
    print(f"\n{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
    return 1 if counts["failed"] or not counts["passed"] else 0
