"""SLCAN with programs of other people, inside the guest of vcan_vm.sh: the kernel's driver behind our gateway, and can-utils' adapter before
our driver. In a guest a terminal holds characters back for one tick of its clock, 10 ms, so tilt data are often too old to walk by: every node
is asked, configured and started, and the frames are counted."""
import os
import re
import sys
import time

from harness import Failed, Hoist, Program, check, run, run_suite, until

BIN = sys.argv[1]


def with_hoist(hoist, case):
    try:
        case()
    except Failed:
        print(hoist.logs())
        raise
    finally:
        hoist.stop()


def slcand_drives_the_kernel_behind_our_gateway():
    hoist = Hoist(BIN, None, "socketcan:slcan0")
    slcand = None

    def case():
        nonlocal slcand
        hoist.start_sim()
        terminal = os.path.realpath(hoist.path("can"))
        slcand = Program(hoist.folder, "slcand", "slcand", "-o", "-c", "-s5", "-S", "1000000", "-F", terminal, "slcan0")
        until("slcan0 exists", lambda: os.path.exists("/sys/class/net/slcan0"))
        run("ip", "link", "set", "slcan0", "txqueuelen", "12", "up")
        hoist.start_core()
        hoist.start_server()
        hoist.nodes_run()
        refused = hoist.status()["bus"]["refused"]
        check(refused == 0, f"{refused} frames refused behind the kernel's driver")
        # The adapter is pulled out: slcand ends and takes the interface with it.
        said = hoist.core.said()
        slcand.end()
        hoist.core.says("bus: ", behind=said)
        until("nothing can start", lambda: hoist.mode() != "standby" and "nodes_missing" in hoist.status()["blocked"])
        # And put back.
        slcand = Program(hoist.folder, "slcand", "slcand", "-o", "-c", "-s5", "-S", "1000000", "-F", terminal, "slcan0")
        until("slcan0 exists", lambda: os.path.exists("/sys/class/net/slcan0"))
        run("ip", "link", "set", "slcan0", "txqueuelen", "12", "up")
        hoist.nodes_run()

    try:
        with_hoist(hoist, case)
    finally:
        if slcand is not None:
            slcand.end()


def our_driver_speaks_through_slcanpty():
    hoist = Hoist(BIN, "socketcan:vcan0", None)
    adapter = None

    def case():
        nonlocal adapter
        adapter = Program(hoist.folder, "slcanpty", "stdbuf", "-oL", "slcanpty", "/dev/ptmx", "vcan0")
        terminal = until("slcanpty names its terminal", lambda: re.search(r"/dev/pts/\d+", adapter.output())).group(0)
        hoist.core_bus = f"slcan:{terminal}"
        hoist.start_sim()
        hoist.start_core()
        hoist.start_server()
        hoist.nodes_run()
        # The adapter writes past a terminal that is full, which cuts a line: that happens to a reader that is delayed by 40 ms.
        bus = until("a thousand frames", lambda: (now := hoist.status()["bus"])["frames"] >= 1000 and now)
        check(bus["refused"] <= 0.02 * bus["frames"], f"{bus['refused']} of {bus['frames']} lines refused")
        # The adapter is pulled out.
        said = hoist.core.said()
        adapter.end()
        hoist.core.says("bus: the device has gone away", behind=said)
        until("nothing can start", lambda: hoist.mode() != "standby" and "nodes_missing" in hoist.status()["blocked"])
        time.sleep(0.5)
        check(hoist.core.process.poll() is None, "the core goes on without an adapter")

    try:
        with_hoist(hoist, case)
    finally:
        if adapter is not None:
            adapter.end()


def cansend_reaches_the_simulated_bus_through_our_gateway():
    """A frame written by a foreign tool reaches the nodes, and a node's answer returns."""
    hoist = Hoist(BIN, None, None)
    slcand = None

    def case():
        nonlocal slcand
        hoist.start_sim()
        slcand = Program(hoist.folder, "slcand", "slcand", "-o", "-c", "-s5", "-S", "1000000", "-F", os.path.realpath(hoist.path("can")), "slcan0")
        until("slcan0 exists", lambda: os.path.exists("/sys/class/net/slcan0"))
        run("ip", "link", "set", "slcan0", "up")
        dump = Program(hoist.folder, "candump", "stdbuf", "-oL", "candump", "-L", "slcan0,581:7FF")
        # Until it is heard: the first may fall into the time before the gateway's line is open.

        def ask():
            run("cansend", "slcan0", "601#4018100200000000")
            return "581#43181002" in dump.output()

        until("the left drive says what it is", ask, 30.0, 0.3)
        dump.end()

    try:
        with_hoist(hoist, case)
    finally:
        if slcand is not None:
            slcand.end()


if __name__ == "__main__":
    sys.exit(run_suite("SlcanPeers", [
        cansend_reaches_the_simulated_bus_through_our_gateway,
        slcand_drives_the_kernel_behind_our_gateway,
        our_driver_speaks_through_slcanpty,
    ]))
