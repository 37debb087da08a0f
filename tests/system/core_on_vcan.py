"""The whole hoist on a real CAN interface: simulated nodes, control core and server as processes, inside the guest of vcan_vm.sh."""
import json
import os
import socket
import struct
import subprocess
import sys
import time

import canmatrix.formats
from harness import Hoist, Program, check, run, run_hoist, until

BIN = sys.argv[1]
TOP = sys.argv[2]
NAME = "hoist0"
hoist = None

ERROR_FLAG = 0x20000000
ERROR_CONTROL, ERROR_BUS_OFF, ERROR_RESTARTED = 0x4, 0x40, 0x100


def make_interface():
    run("ip", "link", "add", NAME, "type", "vcan")
    run("ip", "link", "set", NAME, "up")


def inject(error_class, control=0):
    """Writes an error frame to the interface, as a controller's driver would report it."""
    with socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as line:
        line.bind((NAME, ))
        line.send(struct.pack("=IB3x8B", ERROR_FLAG | error_class, 8, 0, control, 0, 0, 0, 0, 0, 0))


def again():
    """What every case begins with: standing, ready, at the start mark."""
    hoist.recover()
    hoist.place_anew()


def stops_with(*faults):
    """Whatever else: the machine stands, and one of these is named."""
    until("the core stops", lambda: hoist.mode() not in ("user", "standby"), 60.0)
    until(f"the core names one of {faults}", lambda: set(hoist.status()["faults"]) & set(faults))
    hoist.wait_stopped()


def walks_and_every_frame_means_the_same_to_an_independent_reader():
    again()
    log = hoist.path("candump.log")
    with open(log, "wb") as file:
        dump = subprocess.Popen(["candump", "-L", NAME], stdout=file)
    hoist.walk()
    dump.terminate()
    dump.wait()
    hoist.call("POST", "/stop", {})
    hoist.wait_stopped()

    # Our own reader ...
    ours = [json.loads(line) for line in run(os.path.join(BIN, "hoist"), "bus", "log", "--json", log).splitlines()]
    check(len(ours) > 500, f"only {len(ours)} frames while walking")
    unknown = {frame["id"] for frame in ours if frame["name"] is None}
    check(not unknown, f"frames nobody knows: {sorted(map(hex, unknown))}")
    problems = [frame for frame in ours if "problem" in frame]
    check(not problems, f"refused: {problems[:3]}")
    # ... and the generated DBC in the hands of canmatrix.
    matrix = list(canmatrix.formats.loadp(os.path.join(TOP, "control/contract/hoist.gen.dbc")).values())[0]
    frames = {frame.arbitration_id.id: frame for frame in matrix.frames}
    compared, seen = 0, set()
    with open(log) as file:
        for mine, line in zip(ours, file):
            identifier, data = line.split()[2].split("#")
            identifier, data = int(identifier, 16), bytes.fromhex(data)
            check(identifier == mine["id"], f"line by line: {identifier:03X} against {mine['id']:03X}")
            theirs = frames.get(identifier)
            check(theirs is not None, f"{identifier:03X} is not in the DBC")
            check(theirs.name == mine["name"], f"{identifier:03X} is {theirs.name} in the DBC, {mine['name']} to us")
            check(len(data) == theirs.size, f"{theirs.name} has {len(data)} bytes, {theirs.size} in the DBC")
            if not data:
                continue
            for field, decoded in theirs.decode(data).items():
                check(field in mine["fields"], f"{theirs.name} has no {field} to us")
                check(abs(float(decoded.phys_value) - mine["fields"][field]) < 1e-6, f"{theirs.name}.{field}: {decoded.phys_value} against {mine['fields'][field]}")
                compared += 1
            seen.add(theirs.name)
    check(compared > 1500, f"only {compared} values compared")
    for name in ("drive_left_tx1", "drive_right_rx1", "tilt_base_tx2", "io_tx1", "sync", "tilt_left_heartbeat", "core_heartbeat"):
        check(name in seen or name == "sync", f"{name} never came")
    print(f"         {len(ours)} frames, {compared} values the same to both")


def the_engineers_tool_reads_beside_the_computer_and_does_not_disturb_it():
    again()
    scan = run(os.path.join(BIN, "hoist"), "bus", "scan", "--bus", f"socketcan:{NAME}")
    for node in ("drive_left", "drive_right", "io", "tilt_left", "tilt_right", "tilt_base"):
        check(node in scan, f"{node} is not in what scan found: {scan}")
    speed = run(os.path.join(BIN, "hoist"), "bus", "read", "drive_left", "velocity_gain", "--bus", f"socketcan:{NAME}")
    check("0.12" in speed, f"velocity_gain: {speed}")
    refused = subprocess.run([os.path.join(BIN, "hoist"), "bus", "write", "drive_left", "velocity_gain", "0.2", "--bus", f"socketcan:{NAME}"],
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60, check=False)
    check(refused.returncode != 0, f"wrote into a drive beside a running computer: {refused.stdout}")
    again()


def a_link_that_goes_down_stops_the_hoist_and_it_comes_back():
    again()
    hoist.walk()
    said = hoist.core.said()
    run("ip", "link", "set", NAME, "down")
    hoist.core.says("the interface is down", behind=said)
    stops_with("bus_down")
    run("ip", "link", "set", NAME, "up")
    again()
    hoist.walk(0.2)


def an_interface_that_is_removed_and_made_anew():
    again()
    hoist.walk()
    said = hoist.core.said()
    run("ip", "link", "del", NAME)
    stops_with("bus_down")
    hoist.core.says("there is no such interface", behind=said)
    make_interface()
    again()
    hoist.walk(0.2)


def bus_off_stops_the_hoist_until_the_controller_is_restarted():
    again()
    hoist.walk()
    said = hoist.core.said()
    inject(ERROR_BUS_OFF)
    stops_with("bus_down")
    hoist.core.says("bus-off", behind=said)
    time.sleep(1.0)  # and up() stays false: data that still arrive do not prove that we may send
    check("bus_down" in hoist.status()["faults"], "bus-off went away by itself")
    hoist.take_lease()
    code, _ = hoist.call("POST", "/acknowledge", {})
    check(hoist.mode() != "standby", f"acknowledged while bus-off ({code})")
    inject(ERROR_RESTARTED)
    again()
    hoist.walk(0.2)


def an_error_passive_controller_goes_on():
    # Passive still speaks.
    hoist.walks_on("error-passive", lambda: inject(ERROR_CONTROL, 0x20))
    inject(ERROR_CONTROL, 0x40)


def a_flood_from_somebody_else_does_not_break_the_loop():
    again()
    # As fast as the guest can: far more than any bus carries, with ids that none of our nodes has.
    flood = Program(hoist.folder, "cangen", "cangen", NAME, "-g", "0", "-I", "3F0", "-L", "8", "-n", "20000")
    flood.process.wait(60)
    check(hoist.core.process.poll() is None, "the core has ended")
    again()
    hoist.walk(0.2)


def h26_a_wall_clock_that_jumps_changes_nothing():
    for jump in ("2021-03-04 05:06:07", "2044-05-06 07:08:09"):
        hoist.walks_on(f"the clock was set to {jump}", lambda jump=jump: run("date", "-s", jump))
        code, answer = hoist.call("POST", "/lease", {"take_over": True})
        check(code == 200, f"the lease and the signed-in script outlive it: {code} {answer}")


def ends_with_a_controlled_stop():
    again()
    hoist.walk()
    check(hoist.core.end() == 0, "exit code")
    check("stopped" in hoist.core.output(), "says so")
    hoist.wait_stopped()
    log = hoist.path("core.log")
    own = run(os.path.join(BIN, "hoist"), "bus", "log", "--count", log)
    check("drive_left_rx1" in own and "tilt_base_tx1" in own, "the core's own recording")
    hoist.core = None


def main():
    global hoist
    make_interface()
    hoist = Hoist(BIN, f"socketcan:{NAME}", f"socketcan:{NAME}", core_options=())
    hoist.core_options = ["--capture", hoist.path("core.log")]
    return run_hoist("CoreOnVcan", hoist, [
        walks_and_every_frame_means_the_same_to_an_independent_reader,
        the_engineers_tool_reads_beside_the_computer_and_does_not_disturb_it,
        a_link_that_goes_down_stops_the_hoist_and_it_comes_back,
        an_interface_that_is_removed_and_made_anew,
        bus_off_stops_the_hoist_until_the_controller_is_restarted,
        an_error_passive_controller_goes_on,
        a_flood_from_somebody_else_does_not_break_the_loop,
        h26_a_wall_clock_that_jumps_changes_nothing,
        ends_with_a_controlled_stop,
    ])


if __name__ == "__main__":
    sys.exit(main())
