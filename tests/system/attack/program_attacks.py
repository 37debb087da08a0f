"""What may happen to the programs: killed, held, addressed by strangers on the core's socket and on the bus."""
import json
import os
import random
import signal
import socket
import threading
import time

from driving_attacks import drive
from ground import attack, beside, check, check_safe, until
from wire import Line, request

SEED = 20261124
PARAMETER = "lean_tau_normal_s"


def kill(program):
    program.process.send_signal(signal.SIGKILL)
    program.process.wait(10)


@attack("walking")
def the_server_killed_while_walking(ground):
    """Three times, once during downloads: the walk continues, and the next server continues recording."""
    hoist = ground.hoist
    for round_ in range(3):
        if round_ == 1:
            lines = [Line(ground.port) for _ in range(8)]
            for line in lines:
                line.send(request(ground.port, "GET", "/api/v1/sessions/1/export?format=json", [ground.bearer]))
        kill(hoist.server)
        check_safe(hoist.truth()["enabled"], "the drives were switched off with the server")
        hoist.start_server()
        until("the new server finds it walking", lambda: hoist.status()["connected"] and hoist.mode() == "user", 10.0)
        ground.database_is_whole()
    until("it is being recorded again", lambda: hoist.call("GET", "/recording")[1]["state"] == "recording", 10.0)


@attack("walking")
def the_server_held_while_walking(ground):
    hoist = ground.hoist
    hoist.server.process.send_signal(signal.SIGSTOP)
    try:
        begin = hoist.truth()
        time.sleep(2.0)
        check(hoist.truth()["enabled"] and hoist.truth()["progress_m"] != begin["progress_m"], "the walk ended with the server")
    finally:
        hoist.server.process.send_signal(signal.SIGCONT)


@attack("stopped")
def the_server_killed_while_driving(ground):
    driver = drive(ground)
    try:
        kill(ground.hoist.server)
        ground.stands(2.0)
    finally:
        driver.close()
        if ground.hoist.server.process.poll() is not None:
            ground.hoist.start_server()
    until("the new server finds the core", lambda: ground.hoist.status()["connected"], 10.0)


@attack("stopped")
def the_server_held_while_driving(ground):
    driver = drive(ground)
    ground.hoist.server.process.send_signal(signal.SIGSTOP)
    try:
        ground.stands(2.0)
    finally:
        ground.hoist.server.process.send_signal(signal.SIGCONT)
        driver.close()
    ground.stands(0.5)


@attack("standby")
def settings_saved_over_kills_of_the_core(ground):
    """A setting acknowledged with 200 survives kill -9, or the answer says that it is not stored."""
    hoist = ground.hoist
    for round_ in range(6):
        value = 11.0 + round_
        code, answer = hoist.call("PUT", f"/parameters/{PARAMETER}", {"value": value})
        kill(hoist.core)
        check(code == 200, f"the setting was refused: {code} {answer}")
        hoist.start_core()
        until("the server finds the new core", lambda: hoist.status()["connected"], 10.0, 0.05)
        check(not hoist.status()["faults"] or "parameters_corrupt" not in hoist.status()["faults"], "the parameter file is damaged")
        now = until("parameters", lambda: hoist.call("GET", f"/parameters/{PARAMETER}")[1].get("value"), 10.0, 0.05)
        stored = "not stored" not in json.dumps(answer) and answer.get("stored", True)
        check(now == value or not stored, f"kill {round_ + 1}: {value} was acknowledged, {now} is in force: {answer}")
    # The lease ended with the core it came from.
    hoist.recover()


@attack("walking")
def strangers_at_the_cores_socket(ground):
    """Clients of the core's socket that send invalid data, nothing, or leave: the walk continues and the server stays or reconnects."""
    chance = random.Random(SEED)
    path = ground.hoist.path("core.sock")
    held = []
    for i in range(40):
        line = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM if i % 4 else socket.SOCK_SEQPACKET)
        line.settimeout(1.0)
        try:
            line.connect(path)
            if i % 3:
                line.sendall(chance.randbytes(chance.choice((1, 8, 64, 4096))))
            if i % 5 == 0:
                socket.send_fds(line, [b"x"], [os.open("/dev/null", os.O_RDONLY)])
        except OSError:
            pass
        if i % 2:
            line.close()
        else:
            held.append(line)
    time.sleep(0.5)
    for line in held:
        line.close()
    until("the server has the core", lambda: ground.hoist.status()["connected"], 10.0)


@attack("walking")
def nonsense_on_the_bus(ground):
    """Frames of unknown identifiers, remote and extended ones, and invalid text, into the gateway beside the core's frames."""
    chance = random.Random(SEED)
    # Identifiers that no node and no protocol of CANopen uses here.
    unknown = [identifier for identifier in range(0x300, 0x380) if identifier & 0x7F > 0x40]
    line = os.open(ground.hoist.path("can"), os.O_WRONLY | os.O_NOCTTY)
    try:
        for i in range(300):
            data = chance.randbytes(chance.randint(0, 8))
            text = (f"t{chance.choice(unknown):03X}{len(data)}{data.hex().upper()}", f"r{chance.choice(unknown):03X}8",
                    f"T1{chance.randrange(1 << 28):07X}{len(data)}{data.hex().upper()}", "t7FF9", "t12", "x" * chance.randint(1, 200), "t3458", "")[i % 8]
            os.write(line, text.encode() + b"\r")
            time.sleep(0.01)
    finally:
        os.close(line)


@attack("walking")
def everything_at_once(ground):
    """Broken-off downloads, floods, silent connections and wrong requests together, for five seconds; then STOP is checked."""
    over = threading.Event()

    def worker(number):
        chance = random.Random(SEED + number)
        while not over.is_set():
            try:
                line = Line(ground.port, 2.0)
                line.send((request(ground.port, "GET", "/api/v1/sessions/1/export", [ground.bearer]), chance.randbytes(300) + b"\r\n\r\n",
                           request(ground.port, "POST", "/api/v1/lease", [ground.bearer, ground.json_type], b'{"take_over":1}'), b"GET / HT")[number % 4])
                line.read_some(chance.random() * 0.02)
                line.reset()
            except OSError:
                pass
            time.sleep(0.02)  # this computer must also be the machine

    threads = beside(8, worker)
    time.sleep(5.0)
    over.set()
    for thread in threads:
        thread.join()
