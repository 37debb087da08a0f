"""`deploy/dev run` as a newcomer starts it: in lock-step and by the wall clock, a program that dies, a second start, Ctrl-C and a script that
is killed outright."""
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile

from harness import Failed, Hoist, Program, check, run_suite, until

BIN = sys.argv[1]
TOP = sys.argv[2]
PROGRAMS = ("hoist-sim", "hoist-control", "hoist-server")


def refused(*options):
    """A start that is to be refused: its exit code and what it says."""
    done = subprocess.run([os.path.join(TOP, "deploy/dev"), "run", *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=120, check=False)
    return done.returncode, done.stdout


class Demo:
    """One `deploy/dev run` with folders and a port of its own."""

    def __init__(self, *options):
        self.folder = tempfile.mkdtemp(prefix="hoist-run-")
        self.hoist = Hoist(BIN, None, None)
        self.hoist.folder = os.path.join(self.folder, "state")
        with socket.socket() as line:
            line.bind(("127.0.0.1", 0))
            self.hoist.port = line.getsockname()[1]
        self.options = ["--port", str(self.hoist.port), "--state", self.hoist.folder, "--data", os.path.join(self.folder, "data"),
                        "--no-setup", *options]
        self.script = self.start()

    def start(self):
        return Program(self.folder, "run", os.path.join(TOP, "deploy/dev"), "run", *self.options)

    def ready(self):
        """Waits for the line with the address, which must be there for a person to open, and for the nodes."""
        self.script.says(f"Open http://127.0.0.1:{self.hoist.port}/?token=", 120.0)
        with open(self.hoist.path("token")) as file:
            self.hoist.token = file.read().strip()
        self.hoist.nodes_run()

    def programs(self):
        """The command lines of its programs that run, by name."""
        found = {}
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/cmdline", "rb") as file:
                    words = file.read().decode(errors="replace").split("\0")
            except OSError:
                continue
            name = os.path.basename(words[0])
            if name in PROGRAMS and any(word.startswith(self.folder) for word in words):
                found[name] = int(pid), words
        return found

    def over(self):
        until("its programs have ended", lambda: not self.programs(), 30.0)


def with_demo(case, *options):
    demo = Demo(*options)
    try:
        demo.ready()
        check(set(demo.programs()) == set(PROGRAMS), f"these run: {sorted(demo.programs())}")
        case(demo)
    except Failed:
        print(demo.script.output()[-3000:])
        raise
    finally:
        demo.script.end()
        demo.over()


def lock_step_is_the_default_and_a_program_that_dies_is_started_again():
    def case(demo):
        core_pid, words = demo.programs()["hoist-control"]
        check(words[words.index("--bus") + 1].startswith("sim:"), f"the core's bus: {words}")
        check("loop_late_s_max=0.2" not in words, "in lock-step no bound needs to be wider")
        os.kill(core_pid, signal.SIGKILL)
        demo.script.says("hoist-control ended", 10.0)
        until("another core runs", lambda: demo.programs().get("hoist-control", (core_pid,))[0] != core_pid)
        demo.hoist.nodes_run()
        # A second start in the same place says why it cannot, and harms nothing.
        code, said = refused(*demo.options)
        check(code == 1 and "another 'deploy/dev run' uses" in said, f"{code}: {said}")
        demo.hoist.nodes_run()
        check(demo.script.end(signal.SIGINT) == 0, "Ctrl-C is no error")
        left = set(os.listdir(demo.hoist.folder)) - {"lock", "token.sessions"}  # who is signed in stays so when it is started again
        check(not left, f"left behind: {left}")

    with_demo(case)


def real_time_goes_by_the_wall_clock_over_a_serial_line():
    def case(demo):
        _, words = demo.programs()["hoist-control"]
        check(words[words.index("--bus") + 1].startswith("slcan:"), f"the core's bus: {words}")
        check("--lock-step" not in demo.programs()["hoist-sim"][1], "the simulator has a clock of its own")
        # Nothing but the wall clock makes the simulator's time go on while the core is held.
        core_pid, _ = demo.programs()["hoist-control"]
        os.kill(core_pid, signal.SIGSTOP)
        try:
            before_s = demo.hoist.truth()["time_s"]
            until("the simulator goes on without the core", lambda: demo.hoist.truth()["time_s"] > before_s + 2.0)
        finally:
            os.kill(core_pid, signal.SIGCONT)

    with_demo(case, "--real-time", "--scenario", "straight")


def a_script_that_is_killed_takes_its_programs_along():
    def case(demo):
        demo.script.process.kill()
        demo.over()

    with_demo(case)


def what_cannot_be_is_refused_before_anything_starts():
    for options, reason in ((["--port", "70000"], r"1 to 65535"), (["--scenario", "a b"], r"letters, digits"), (["--port"], r"needs a value"),
                            (["--fast"], r"does not know '--fast'")):
        code, said = refused("--no-setup", *options)
        check(code != 0 and re.search(reason, said), f"{options}: {code} {said}")


if __name__ == "__main__":
    sys.exit(run_suite("RunVerb", [
        what_cannot_be_is_refused_before_anything_starts,
        lock_step_is_the_default_and_a_program_that_dies_is_started_again,
        real_time_goes_by_the_wall_clock_over_a_serial_line,
        a_script_that_is_killed_takes_its_programs_along,
    ]))
