"""What the suites share: the real programs as processes, waiting for what they do, and a report of every case.

Nothing here measures time: a wait ends when the thing has happened, and only fails when it has not for very long, because a guest is slow
and the machine around it may be busy.
"""
import http.client
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import traceback
import urllib.error
import urllib.request
from xml.sax.saxutils import quoteattr


class Failed(Exception):
    """A case found something wrong."""


class Unsafe(Exception):
    """An invariant of the wheels was violated, measured in simulated time or in the core's own recording: never tried again, because a busy
    machine cannot have done it."""


class Skipped(Exception):
    """A case cannot be tried here; says why."""


def check(condition, message):
    if not condition:
        raise Failed(message)


def check_safe(condition, message):
    if not condition:
        raise Unsafe(message)


def until(what, ask, within_s=30.0, each_s=0.1):
    """Polls `ask` until its result is true, and returns it."""
    end = time.monotonic() + within_s
    while True:
        value = ask()
        if value:
            return value
        if time.monotonic() > end:
            raise Failed(f"{what}: not within {within_s:.0f} s")
        time.sleep(each_s)


def utc_offset_s():
    """What must be added to time.monotonic() to get the time of day. Both clocks cannot be read at once: the best of some tries, because this
    program may be held up between the two."""
    best = None
    for _ in range(20):
        before_s, wall_s, after_s = time.monotonic(), time.time(), time.monotonic()
        if best is None or after_s - before_s < best[0]:
            best = (after_s - before_s, wall_s - (before_s + after_s) / 2)
    return best[1]


def run(*command, **options):
    """Runs a command to its end; gives its output, fails when it fails."""
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60, check=False, **options)
    except subprocess.TimeoutExpired as error:
        raise Failed(str(error)) from None
    check(done.returncode == 0, f"{' '.join(command)} ended with {done.returncode}: {done.stdout[-2000:]}")
    return done.stdout


class Program:
    """A program that runs beside the test; its output goes to a file."""

    def __init__(self, folder, name, *command):
        self.name = name
        self.path = os.path.join(folder, f"{name}.log")
        self.begin = os.path.getsize(self.path) if os.path.exists(self.path) else 0  # what an earlier life said does not count
        with open(self.path, "ab") as output:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT)

    def output(self):
        with open(self.path, errors="replace") as file:
            file.seek(self.begin)
            return file.read()

    def said(self):
        """How much it has said so far. What it says because of something that a test does comes behind this."""
        return len(self.output())

    def says(self, text, within_s=30.0, behind=0):
        def ask():
            ended = self.process.poll() is not None
            found = text in self.output()[behind:]
            check(found or not ended, f"{self.name} has ended ({self.process.returncode}): {self.output()[-1500:]}")
            return found

        until(f"{self.name} says \"{text}\"", ask, within_s)

    def end(self, number=signal.SIGTERM, within_s=20.0):
        """Ends it, also a stopped one, and gives its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(number)
            self.process.send_signal(signal.SIGCONT)
            try:
                self.process.wait(within_s)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
                raise Failed(f"{self.name} did not end: {self.output()[-1500:]}") from None
        return self.process.returncode


class Hoist:
    """Simulator, control core and server in a folder of their own."""

    def __init__(self, bin_folder, sim_bus, core_bus, scenario="straight", sim_options=(), core_options=()):
        self.bin = bin_folder
        self.folder = tempfile.mkdtemp(prefix="hoist-")
        self.sim_bus, self.core_bus = sim_bus, core_bus
        self.scenario = scenario
        self.sim_options, self.core_options = list(sim_options), list(core_options)
        self.real_time = False
        self.lock_step = False  # simulator and core on one clock
        self.recording = None  # where the core writes down what passes on the bus
        self.recording_begin = 0  # of the core that runs now
        self.utc_offset_s = 0.0  # of the recording's times
        self.sim = self.core = self.server = None
        self.epoch = None

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def program(self, name, *arguments):
        return Program(self.folder, name, os.path.join(self.bin, name), *arguments)

    def start_sim(self):
        where = ["--bus", self.sim_bus] if self.sim_bus else ["--pty-link", self.path("can")]
        if self.lock_step:
            where = ["--lock-step", self.path("step.sock")]
        self.sim = self.program("hoist-sim", "--scenario", self.scenario, "--control", self.path("sim.sock"), *where, *self.sim_options)
        self.sim.says("SIMULATION")

    def start_core(self):
        bus = self.core_bus or f"slcan:{self.path('can')}"
        # A guest's clock ticks at 100 Hz and its processor is shared: late steps are the guest's, not the core's.
        bound = ["--set", "loop_late_s_max=0.2"]
        if self.lock_step:
            bus, bound = f"sim:{self.path('step.sock')}", []
        capture = ["--capture", self.recording] if self.recording else []
        # The core compares the two clocks once, at its start. Setting the time of day in that moment would shift the
        # whole recording.
        for _ in range(3):
            if self.recording and os.path.exists(self.recording):
                self.recording_begin = os.path.getsize(self.recording)
            before_s = utc_offset_s()
            self.core = self.program("hoist-control", "--bus", bus, "--socket", self.path("core.sock"), *bound,
                                     *([] if self.real_time else ["--no-realtime"]), *capture, *self.core_options)
            self.core.says("100 Hz")
            self.utc_offset_s = utc_offset_s()
            if not self.recording or abs(self.utc_offset_s - before_s) < 0.02:
                return
            self.core.end()
        raise Failed("this machine's clock is set all the time")

    def start_server(self):
        # The server takes a free port and prints it: a port that is looked up before may be taken by then.
        self.server = self.program("hoist-server", "--socket", self.path("core.sock"), "--port", "0", "--db", self.path("hoist.db"),
                                   "--token-file", self.path("token"))
        self.server.says("Open http")
        self.port = int(until("the server names its port", lambda: re.search(r"Open http://[^ ]*?:(\d+)[/ \n]", self.server.output())).group(1))
        with open(self.path("token")) as file:
            self.token = file.read().strip()

    def start(self):
        self.start_sim()
        self.start_core()
        self.start_server()
        self.recover()

    def stop(self):
        """Ends all three, independent of errors."""
        problem = None
        for program in (self.server, self.core, self.sim):
            try:
                if program is not None:
                    program.end()
            except Failed as error:
                problem = error
        if problem is not None:
            raise problem

    def forget(self):
        """Their files are no longer needed."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def logs(self):
        return "\n".join(f"--- {p.name}\n{p.output()[-3000:]}" for p in (self.sim, self.core, self.server) if p is not None)

    # The server's API.
    def call(self, method, path, body=None):
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}/api/v1{path}", method=method, data=None if body is None else json.dumps(body).encode())
        request.add_header("Authorization", f"Bearer {self.token}")
        if body is not None:
            request.add_header("Content-Type", "application/json")
        if method in ("PUT", "PATCH", "DELETE"):
            request.add_header("If-Match", "*")  # for any ETag
        if self.epoch is not None:
            request.add_header("X-Hoist-Lease", str(self.epoch))
        try:
            try:
                with urllib.request.urlopen(request, timeout=20) as answer:
                    return answer.status, json.loads(answer.read() or b"{}")
            except urllib.error.HTTPError as error:
                return error.code, json.loads(error.read() or b"{}")
        except (OSError, http.client.HTTPException) as error:
            raise Failed(f"{method} {path}: {error!r}") from None

    def status(self):
        return self.call("GET", "/status")[1]["core"]

    def take_lease(self):
        def ask():
            code, answer = self.call("POST", "/lease", {"take_over": True})
            check(code in (200, 503), f"lease: {answer}")  # 503: the core did not answer in time, as may be in a guest that was held up
            return answer if code == 200 else None

        self.epoch = until("the core gives the lease", ask)["epoch"]

    def mode(self):
        return self.status()["mode"]

    def wait_mode(self, mode, within_s=60.0):
        until(f"mode {mode}", lambda: self.mode() == mode, within_s)

    def recover(self):
        """To standby with nothing in the way of walking: out of the start, of walking, or of a stop whose cause is gone. A slow machine may
        stumble on the way, so this goes on until it has worked."""

        def ask():
            now = self.status()
            if not now["connected"]:
                return False
            if now["mode"] == "standby":
                if "not_neutral" in now["blocked"]:
                    self.ask_sim(op="reset")  # the patient stands upright again; refused while a drive is still on
                return set(now["blocked"]) <= {"no_lease"}
            if now["mode"] == "user":
                self.call("POST", "/stop", {})
            self.take_lease()
            self.call("POST", "/acknowledge", {})
            return False

        try:
            until("ready in standby", ask, 150.0, 0.3)
        except Failed as error:
            raise Failed(f"{error}; {self.status()}") from None

    def walk(self, at_least_m=0.5):
        """Lets the patient lead and waits until the machine has moved.

        On a busy machine the simulated patient may give up waiting, or the core may stop because frames came too late. Neither is what a
        case is about, so it is tried again for as long as a machine may be busy; a walk that has ended in a stop is not waited for.
        """
        end = time.monotonic() + 120.0
        while True:
            start = self.truth()

            def walked():
                mode = self.mode()
                check(mode in ("standby", "user"), f"the walk ended in {mode}")
                if mode == "standby":
                    self.take_lease()
                    self.call("POST", "/mode", {"mode": "user", "exercise": {"shape": "straight", "length_m": 10}})
                    return False
                return abs(self.truth()["x_m"] - start["x_m"]) > at_least_m

            try:
                until("the machine moves", walked, 40.0, 0.2)
                return
            except Failed as error:
                if time.monotonic() > end:
                    raise Failed(f"{error}; {self.status()}; {self.truth()}") from None
                print(f"[ WALK ] once more: {error}", flush=True)
                self.recover()
                self.place_anew()

    def walks_on(self, what, act, at_least_m=0.3):
        """Lets the patient walk and calls `act`, which must not end the walk. A guest that was held up ends it as well, so this is tried again:
        what is broken ends every walk."""
        tries = 5
        for one in range(tries):
            self.recover()
            self.place_anew()
            self.walk()
            act()
            before_m = self.truth()["x_m"]

            def went():
                return self.mode() != "user" or abs(self.truth()["x_m"] - before_m) > at_least_m

            until(f"{what}: it goes on walking, or stops", went, 60.0)
            now = self.status()
            if now["mode"] == "user":
                return
        raise Failed(f"{what}: the walk ended {tries} times, at last with {now['faults']}")

    def nodes_run(self):
        """Waits until every node has answered the core's questions, has taken its values, runs on command and sends: frames pass both ways. For
        lines on which a guest is too slow for a walk."""

        def ask():
            now = self.status()
            return now["connected"] and "nodes_missing" not in now["blocked"]

        try:
            until("every node runs", ask, 90.0, 0.05)
        except Failed as error:
            raise Failed(f"{error}; {self.status()}") from None

    def wait_stopped(self):
        """At rest, with the bridges off or held."""
        until("the machine stands", lambda: abs(self.truth()["speed_m_s"]) < 0.01, 60.0, 0.1)

    # The simulator's truth and faults.
    def ask_sim(self, **request):
        try:
            with socket.socket(socket.AF_UNIX) as line:
                line.settimeout(20)
                line.connect(self.path("sim.sock"))
                line.sendall(json.dumps(request).encode() + b"\n")
                answer = b""
                while not answer.endswith(b"\n"):
                    piece = line.recv(65536)
                    check(piece, "the simulator closed its socket")
                    answer += piece
        except OSError as error:
            raise Failed(f"the simulator, asked for {request}: {error!r}") from None
        return json.loads(answer)

    def truth(self):
        return self.ask_sim(op="state")

    def place_anew(self):
        """Patient and machine back at the start mark."""
        until("the simulator restarts", lambda: "ok" in self.ask_sim(op="reset"), 60.0, 0.2)


def run_hoist(name, hoist, cases):
    """Starts the programs, runs the cases on them and ends them; their last words are printed when something failed. Gives
    the exit code."""
    code = 1
    try:
        try:
            once(hoist.start)
        except Failed as error:
            print(f"the programs did not start, once more: {error}\n{hoist.logs()}", flush=True)
            hoist.stop()
            once(hoist.start)
        code = run_suite(name, cases)
        if code != 0:
            print(hoist.logs())
    except Failed as error:
        print(f"the programs did not start: {error}\n{hoist.logs()}")
    finally:
        try:
            hoist.stop()
        except Failed as error:
            print(error)
            code = 1
    if code == 0:
        hoist.forget()
    else:
        print(f"what the programs wrote stays in {hoist.folder}")
    return code


def once(case):
    """Runs a case. A connection that broke or took too long is something wrong like any other, and as often the machine's doing."""
    try:
        case()
    except (OSError, http.client.HTTPException, subprocess.TimeoutExpired) as error:
        traceback.print_exc()
        raise Failed(repr(error)) from error


def run_suite(name, cases):
    """Runs the cases, prints how each went and leaves a report as GoogleTest does (GTEST_OUTPUT=xml:FILE). Gives the exit code.

    Every case begins by putting the programs in order, so one that failed is tried once more: these are real programs in real time, and a
    machine that was held up for a second proves nothing. What is broken fails twice. What is unsafe is not tried again, and a case that failed
    cannot say afterwards that it cannot be tried here."""
    only = os.environ.get("HOIST_CASES")
    lines, failures = [], 0
    for case in cases:
        if only and not re.search(only, case.__name__):
            continue
        print(f"[ RUN  ] {name}.{case.__name__}", flush=True)
        body = ""
        result = "completed"
        begin = time.monotonic()
        try:
            try:
                once(case)
            except Failed as error:
                print(f"[AGAIN ] {name}.{case.__name__}: {error}", flush=True)
                try:
                    once(case)
                except Skipped as reason:
                    raise Failed(f"{error}; then: {reason}") from None
            print(f"[   OK ] {name}.{case.__name__} ({time.monotonic() - begin:.1f} s)", flush=True)
        except Skipped as reason:
            print(f"[ SKIP ] {name}.{case.__name__}: {reason}", flush=True)
            result, body = "skipped", f"<skipped message={quoteattr(f'{name}:1{chr(10)}{reason}')}/>".replace("\n", "&#x0A;")
        except Exception as error:  # pylint: disable=broad-except
            failures += 1
            print(f"[ FAIL ] {name}.{case.__name__}: {error}", flush=True)
            if not isinstance(error, (Failed, Unsafe)):
                traceback.print_exc()
            body = f"<failure message={quoteattr(str(error)[:500])}/>".replace("\n", "&#x0A;")
        lines.append(f'<testcase name="{case.__name__}" classname="{name}" status="run" result="{result}" time="{time.monotonic() - begin:.1f}">{body}'
                     "</testcase>")
    target = os.environ.get("GTEST_OUTPUT", "")
    if target.startswith("xml:") and not target.endswith("/"):
        with open(target[4:], "w") as file:
            file.write(f'<testsuites><testsuite name="{name}">{"".join(lines)}</testsuite></testsuites>\n')
    print(f"{len(lines) - failures} of {len(lines)} cases good", flush=True)
    sys.stdout.flush()
    return 1 if failures else 0
