#!/usr/bin/python3
"""Our gateway against python3-can's SLCAN, and `hoist bus` against simulated nodes, over a pseudo terminal of hoist-sim.

usage: slcan_peer.py HOIST_SIM HOIST

Nothing here measures time: a wait ends when the thing has happened.
"""
import json
import os
import pty
import select
import subprocess
import sys
import tempfile
import threading
import time
import traceback
import tty
from xml.sax.saxutils import quoteattr

SIM, HOIST = sys.argv[1:3]
PATIENCE_S = 20.0


class Skipped(Exception):
    """Cannot be tried here; says why."""


def check(condition, message):
    if not condition:
        raise AssertionError(message)


def until(what, ask):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        value = ask()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f"{what}: not within {PATIENCE_S:.0f} s")


class Sim:
    """A simulated hoist behind a pseudo terminal."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.pty = os.path.join(self.folder.name, "gateway")
        self.log = os.path.join(self.folder.name, "sim.log")
        self.output = open(self.log, "wb")
        self.process = subprocess.Popen([SIM, "--pty-link", self.pty], stdin=subprocess.DEVNULL, stdout=self.output, stderr=subprocess.STDOUT)

    def __enter__(self):
        until("the pseudo terminal", lambda: os.path.exists(self.pty))
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(PATIENCE_S)
        self.output.close()
        self.folder.cleanup()

    def closed(self):
        """Whoever had opened the line has closed it, and the simulator knows: what the next one writes at once is not cleared away with what
        the last one left."""
        def ask():
            with open(self.log, encoding="utf-8", errors="replace") as file:
                said = file.read()
            return said.rfind("the line is closed") >= said.rfind("a computer has opened the line")
        until("the line is closed", ask)

    def bus(self, *words, code=0):
        """Runs `hoist bus`; gives what it printed."""
        self.closed()
        done = subprocess.run([HOIST, "bus", "--bus", f"slcan:{self.pty}", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              timeout=60, check=False)
        check(done.returncode == code, f"hoist bus {' '.join(words)} ended with {done.returncode}: {done.stdout}{done.stderr}")
        return done.stdout if code == 0 else done.stderr

    def json(self, *words):
        return json.loads(self.bus(*words, "--json"))


def python_can(sim):
    try:
        import can  # pylint: disable=import-outside-toplevel
        import serial  # noqa: F401  pylint: disable=import-outside-toplevel,unused-import
    except ImportError as problem:
        raise Skipped(f"python3-can with its serial back end is not installed: {problem}") from problem
    return can, can.Bus(interface="slcan", channel=sim.pty, bitrate=250000, sleep_after_open=0.1)


def received(bus, wanted):
    """The next frame that `wanted` accepts."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        message = bus.recv(1.0)
        if message is not None and wanted(message):
            return message
    raise AssertionError("the frame did not come")


def case_python_can_hears_every_node(sim):
    _, bus = python_can(sim)
    with bus:
        heard = set()
        def beat(message):
            if 0x701 <= message.arbitration_id <= 0x77F and message.dlc == 1 and message.data[0] == 127:
                heard.add(message.arbitration_id)
            return len(heard) == 6
        received(bus, beat)
        check(heard == {0x701, 0x702, 0x708, 0x711, 0x712, 0x713}, f"heard {sorted(heard)}")


def case_python_can_asks_and_is_answered(sim):
    can, bus = python_can(sim)
    with bus:
        bus.send(can.Message(arbitration_id=0x601, is_extended_id=False, data=[0x40, 0, 0x10, 0, 0, 0, 0, 0]))
        answer = received(bus, lambda message: message.arbitration_id == 0x581)
        check(bytes(answer.data) == bytes([0x43, 0, 0x10, 0, 0x92, 0x01, 0x02, 0]), f"1000h: {answer}")
        # A drive that is started answers a SYNC, which has no data.
        bus.send(can.Message(arbitration_id=0, is_extended_id=False, data=[1, 1]))
        received(bus, lambda message: message.arbitration_id == 0x701 and message.data[0] == 5)
        bus.send(can.Message(arbitration_id=0x080, is_extended_id=False, data=[]))
        state = received(bus, lambda message: message.arbitration_id == 0x181)
        check(state.dlc == 8, f"TPDO1: {state}")
        # A foreign frame with a long id disturbs nothing.
        bus.send(can.Message(arbitration_id=0x18DAF110, is_extended_id=True, data=[1, 2, 3]))
        bus.send(can.Message(arbitration_id=0x601, is_extended_id=False, data=[0x40, 0x61, 0x60, 0, 0, 0, 0, 0]))
        answer = received(bus, lambda message: message.arbitration_id == 0x581)
        check(answer.data[4] == 3, f"6061h: {answer}")


def case_python_can_opens_and_closes_again(sim):
    for _ in range(3):
        _, bus = python_can(sim)
        with bus:
            received(bus, lambda message: message.arbitration_id > 0x700)
        sim.closed()


def case_hoist_bus_scan(sim):
    def scan():
        nodes = {entry["node"]: entry for entry in sim.json("scan")}
        check(set(nodes) == {"drive_left", "drive_right", "io", "tilt_left", "tilt_right", "tilt_base"}, f"nodes: {sorted(nodes)}")
        for name, entry in nodes.items():
            check(entry["state"] in ("pre-operational", "silent"), f"{name}: {entry}")
            check(entry["hardware"] in ("simulated", ""), f"{name}: {entry}")
        return all(entry["state"] == "pre-operational" and entry["answers"] and entry["hardware"] for entry in nodes.values())
    # It listens for a quarter of a second, and waits no longer for an answer, in which a delayed simulator sends nothing.
    until("every node is heard and answers within one scan", scan)


def case_hoist_bus_read_and_write(sim):
    check(abs(sim.json("read", "drive_left", "velocity_gain")["value"] - 0.12) < 1e-6, "the default")
    sim.bus("write", "drive_left", "2200:1", "0.25")
    entry = sim.json("read", "1", "0x2200:1")
    check(entry["value"] == 0.25 and entry["unit"] == "V s/rad", f"{entry}")
    # A scaled integer is written in its unit.
    sim.bus("write", "drive_left", "target_velocity", "-1.5")
    check(sim.json("read", "drive_left", "60FF")["raw"] == 2**32 - 1500, "the raw value")
    for words, reason in ((("velocity_gain", "5.1"), "outside of 0 to 5"), (("velocity_gain", "nan"), "no number"),
                          (("target_velocity", "0.0005"), "between two steps"), (("6041", "0"), "only be read"),
                          (("4711:1", "0"), "no object"), (("1010:1", "1"), "transferred or stored")):
        said = sim.bus("write", "drive_left", *words, code=1)
        check(reason in said, f"{words}: {said}")
    check(sim.json("read", "drive_left", "velocity_gain")["value"] == 0.25, "unchanged by what was refused")
    check("no node" in sim.bus("read", "drive_middle", "1000", code=1), "an unknown node")


def case_hoist_bus_tells_states_in_words(sim):
    words = sim.json("read", "drive_left", "status_word")["words"]
    check(words.startswith("switch-on disabled, supply"), words)
    check(sim.json("read", "drive_left", "603F")["words"] == "none", "no error")
    check("switch-on disabled" in sim.bus("read", "drive_left", "6041"), "for people, too")
    for name in ("device_name", "1008", "1008h", "0x1008:0"):
        check(sim.json("read", "drive_left", name)["text"] == "Hoist drive", name)
    check(sim.json("dump", "tilt_left")["texts"]["device_name"] == "Hoist tilt sensor", "a dump has the names")
    said = sim.bus("--help")
    for command in ("scan", "monitor", "read", "write", "dump", "restore", "save", "load-defaults", "emcy", "nmt", "reset-fault", "load", "log"):
        check(f"\n  {command} " in said, f"{command}: {said}")


def case_hoist_bus_monitor(sim):
    lines = [json.loads(line) for line in sim.bus("monitor", "--seconds", "2", "--json").splitlines()]
    beats = [line for line in lines if line["name"] == "io_heartbeat"]
    check(len(beats) >= 2 and all(line["words"]["state"] == "pre-operational" for line in beats), f"{beats}")
    check(all(0 <= line["time_s"] < 5 for line in lines), "time since the bus was opened")
    lines = sim.bus("monitor", "--seconds", "2", "--changes", "--only", "tilt_left").splitlines()
    check(len(lines) == 1 and "711 tilt_left_heartbeat" in lines[0] and "(pre-operational)" in lines[0], f"{lines}")
    check("usage" in sim.bus("monitor", "--seconds", "never", code=2), "no number")


def case_hoist_bus_nmt_and_reset_fault(sim):
    def states(*words):
        return {entry["node"]: entry["state"] for entry in sim.json("nmt", *words)}
    until("one is started", lambda: states("drive_left", "start") == {name: "operational" if name == "drive_left" else "pre-operational" for name in
          ("drive_left", "drive_right", "io", "tilt_left", "tilt_right", "tilt_base")})
    until("all are stopped", lambda: set(states("all", "stop").values()) == {"stopped"})
    until("all are reset", lambda: set(states("all", "reset").values()) == {"pre-operational"})
    check("usage" in sim.bus("nmt", "drive_left", "fly", code=2), "no such command")
    check("no node" in sim.bus("nmt", "drive_middle", "start", code=1), "no such node")
    told = sim.json("reset-fault", "drive_left")
    check(not told["fault"] and told["code"] == 0 and "switch-on disabled" in told["status"], f"{told}")
    check("is no drive" in sim.bus("reset-fault", "io", code=1), "not a drive")


def case_hoist_bus_dump_restore_save(sim):
    sim.bus("write", "drive_left", "quick_stop_rad_s2", "250")
    dump = sim.json("dump", "drive_left")
    check(len(dump["objects"]) > 50, f"{len(dump['objects'])} objects")
    path = os.path.join(sim.folder.name, "dump.json")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(dump, file)
    check(sim.json("restore", "drive_right", path)["written"] == 1, "one parameter differs")
    check(sim.json("restore", "drive_right", path)["written"] == 0, "and then none")
    check(sim.json("read", "drive_right", "6085")["raw"] == 250, "restored")
    check(sim.json("read", "drive_right", "1800:1")["raw"] == 0x40000182, "the identifiers stay the node's own")
    check("another kind" in sim.bus("restore", "tilt_left", path, code=1), "a dump of another kind")
    for entry in dump["objects"]:
        if entry["name"] == "current_limit":
            entry["raw"] = 0x7FC00000  # not a number
    with open(path, "w", encoding="utf-8") as file:
        json.dump(dump, file)
    said = sim.bus("restore", "drive_right", path, code=1)
    check("current_limit" in said, said)
    sim.bus("save", "drive_right")
    sim.bus("load-defaults", "drive_right")


def case_hoist_bus_emcy(sim):
    check(sim.json("emcy", "drive_left") == {"error_register": 0, "errors": []}, "no error yet")


def case_hoist_bus_load(sim):
    page = sim.json("load")
    check(page["load_worst_with_service"] < 0.8, f"load {page['load_worst_with_service']}")
    check("## Response times" in sim.bus("load", "--markdown"), "the page")


class AdapterWithComputer:
    """An SLCAN adapter on whose bus a control computer beats, and nobody else."""

    def __init__(self):
        self.ours, self.theirs = pty.openpty()
        tty.setraw(self.theirs)
        self.path = os.ttyname(self.theirs)
        self.heard = b""
        self.longest_gap_s = 0.0  # between two beats
        self.going = True
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        opened, last_s = False, time.monotonic()
        while self.going:
            if select.select([self.ours], [], [], 0.05)[0]:
                lines = os.read(self.ours, 4096)
                self.heard += lines
                for line in lines.split(b"\r")[:-1]:
                    opened = line == b"O" or (opened and line != b"C")
                    os.write(self.ours, b"z\r" if line[:1] == b"t" else b"\r")
            if opened:
                os.write(self.ours, b"t77F105\r")
                self.longest_gap_s = max(self.longest_gap_s, time.monotonic() - last_s)
            last_s = time.monotonic()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.going = False
        self.thread.join()
        os.close(self.ours)
        os.close(self.theirs)


def case_hoist_bus_does_not_write_beside_the_control_computer(_):
    for last_try in (False, False, True):
        with AdapterWithComputer() as adapter:
            try:
                does_not_write_beside(adapter)
                return
            except AssertionError:
                # The tool listens for a quarter of a second; an adapter delayed that long was no control computer.
                if last_try or adapter.longest_gap_s < 0.15:
                    raise


def does_not_write_beside(adapter):
    def bus(*words):
        return subprocess.run([HOIST, "bus", "--bus", f"slcan:{adapter.path}", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True, timeout=60, check=False)
    for words in (("write", "drive_left", "velocity_gain", "0.2"), ("save", "drive_left"), ("load-defaults", "io")):
        done = bus(*words)
        check(done.returncode == 1 and "control computer is at work" in done.stderr, f"{words}: {done.returncode} {done.stderr}")
    # A request that moves a state is refused with any content.
    for words in (("nmt", "all", "stop"), ("nmt", "drive_left", "reset", "--force"), ("reset-fault", "drive_left", "--force")):
        done = bus(*words)
        check(done.returncode == 1 and "control computer is at work" in done.stderr, f"{words}: {done.returncode} {done.stderr}")
    check(b"t60" not in adapter.heard and b"t000" not in adapter.heard and b"t201" not in adapter.heard, f"something was asked: {adapter.heard}")
    done = bus("write", "drive_left", "velocity_gain", "0.2", "--force")
    check(done.returncode == 1 and "does not answer" in done.stderr, f"forced: {done.returncode} {done.stderr}")
    check(adapter.heard.count(b"t60182300220") == 3, f"asked three times: {adapter.heard}")


def case_hoist_bus_without_a_bus(sim):
    done = subprocess.run([HOIST, "bus", "scan", "--bus", f"slcan:{sim.pty}-not"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          timeout=60, check=False)
    check(done.returncode == 1 and "is not there" in done.stderr, f"{done.returncode}: {done.stderr}")


def main():
    if not (os.access(SIM, os.X_OK) and os.access(HOIST, os.X_OK)):
        print("skipped: hoist-sim or hoist is not built")
        return 77
    body, failed = "", 0
    for name, case in list(globals().items()):
        if not name.startswith("case_"):
            continue
        title = name[len("case_"):].replace("_", " ")
        end = "/>"
        try:
            with Sim() as sim:
                case(sim)
            print(f"ok      {title}")
        except Skipped as reason:
            print(f"skipped: {reason} ({title})")
            message = quoteattr(str(reason))[1:-1]
            end = f' result="skipped"><skipped message="slcan_peer.py:1&#x0A;{message}"/></testcase>'
        except Exception as problem:  # pylint: disable=broad-except
            failed += 1
            print(f"FAILED  {title}")
            traceback.print_exc(file=sys.stdout)
            end = f"><failure message={quoteattr(str(problem))}/></testcase>"
        body += f'<testcase name={quoteattr(title)} classname="slcan"{end}'
    target = os.environ.get("GTEST_OUTPUT", "")
    if target.startswith("xml:") and target.endswith("/"):
        with open(os.path.join(target[4:], "slcan_peer.xml"), "w", encoding="utf-8") as file:
            file.write(f'<testsuites><testsuite name="slcan">{body}</testsuite></testsuites>\n')
    return 1 if failed else 0


sys.exit(main())
