"""Bumpers, batteries and synchronisation from a PoKeys on the network instead of the input node: the real programs, on this machine itself."""
import socket
import sys

from harness import Hoist, check, run_hoist, until

BIN = sys.argv[1]
hoist = None


def free_udp_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def again():
    hoist.recover()
    hoist.place_anew()


def the_hoist_walks_without_an_input_node_on_the_bus():
    again()
    check("io" in hoist.truth()["unplugged"], "the simulator's own input node is off the bus")
    hoist.core.says("inputs: come from the PoKeys")
    hoist.walk()
    check(hoist.status()["faults"] == [], f"{hoist.status()['faults']}")


def a_bumper_stops_the_hoist():
    again()
    hoist.walk()
    hoist.ask_sim(op="bumper", which="front", pressed=True)
    try:
        until("the core stops", lambda: hoist.mode() == "protective_stop", 10.0)
        until("the core names the bumper", lambda: "bumper" in " ".join(hoist.status()["faults"]), 10.0)
        hoist.wait_stopped()
    finally:
        hoist.ask_sim(op="bumper", which="front", pressed=False)
    again()


def a_device_that_falls_silent_stops_the_hoist_and_comes_back():
    again()
    hoist.walk()
    said = hoist.core.said()
    hoist.ask_sim(op="pokeys", silent=True)
    try:
        until("the core stops", lambda: hoist.mode() not in ("user", "standby"), 10.0)
        hoist.wait_stopped()
        until("the input node is named as lost", lambda: "io_lost" in hoist.status()["faults"], 10.0)
        hoist.core.says("the device does not answer", behind=said)
    finally:
        hoist.ask_sim(op="pokeys", silent=False)
    again()
    hoist.walk(0.2)


def another_recording_system_is_seen_and_sees_the_hoist():
    again()
    hoist.ask_sim(op="sync_input", on=False)
    hoist.walk(0.2)
    for on in (True, False):
        hoist.ask_sim(op="sync_input", on=on)
        until("the core reads the line", lambda: (hoist.edges() or [None])[-1] == ("on" if on else "off"), 10.0)
    for level in (True, False):
        until(f"the output is {level}", lambda: hoist.truth()["sync_output"] == level, 5.0, 0.02)


class WithEdges(Hoist):
    def edges(self):
        """Levels to which the synchronisation input has changed in the session that is recorded."""
        sessions = self.call("GET", "/sessions?limit=1")[1]["items"]
        events, cursor = [], "" if sessions else None
        while cursor is not None:
            page = self.call("GET", f"/sessions/{sessions[0]['id']}/events?limit=200&cursor={cursor}")[1]
            events, cursor = events + page["items"], page["next"]
        return [event["name"] for event in events if event["kind"] == "sync_input"]


def main():
    global hoist
    port = free_udp_port()
    hoist = WithEdges(BIN, None, None, sim_options=["--pokeys-udp", str(port)], core_options=["--inputs", f"pokeys:udp:127.0.0.1:{port}?sync=9"])
    return run_hoist("PokeysInputs", hoist, [
        the_hoist_walks_without_an_input_node_on_the_bus,
        a_bumper_stops_the_hoist,
        a_device_that_falls_silent_stops_the_hoist_and_comes_back,
        another_recording_system_is_seen_and_sees_the_hoist,
    ])


if __name__ == "__main__":
    sys.exit(main())
