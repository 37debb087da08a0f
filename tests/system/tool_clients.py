"""Foxglove and rosbridge with clients of other people: @foxglove/ws-protocol and roslib (npm ci in tests/system/tools) on the real programs."""
import os
import subprocess
import sys
import urllib.error
import urllib.request

from harness import Failed, Hoist, check, run_hoist, until

BIN, TOP, NODE = sys.argv[1], sys.argv[2], sys.argv[3]
SCRIPT = os.path.join(TOP, "tests", "system", "tools", "clients.mjs")
hoist = None


def script(case):
    done = subprocess.run([NODE, SCRIPT, str(hoist.port), hoist.token, case], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=120, check=False)
    check(done.returncode == 0, f"{case}: {done.stdout[-3000:]}")


def hands(path, headers=()):
    """The status of a WebSocket handshake."""
    request = urllib.request.Request(f"http://127.0.0.1:{hoist.port}{path}")
    for name, value in (("Connection", "Upgrade"), ("Upgrade", "websocket"), ("Sec-WebSocket-Version", "13"), *headers):
        request.add_header(name, value)
    try:
        with urllib.request.urlopen(request, timeout=20) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


def allow(on):
    code, answer = hoist.call("PUT", "/tools", {"enabled": on})
    check(code == 200, f"{answer}")


def both_are_closed_until_an_engineer_opens_them():
    allow(False)
    for path in ("/foxglove", "/rosbridge"):
        check(hands(f"{path}?token={hoist.token}") == 409, f"{path} is open")
    allow(True)
    # Open, and then only with the token: 426 and 400 come from the handshake itself, behind every check.
    check(hands(f"/foxglove?token={hoist.token}") != 409, "/foxglove stays closed")
    for path in ("/foxglove", "/rosbridge"):
        check(hands(path) == 401, f"{path} without a token")
        check(hands(f"{path}?token={'0' * 64}") == 401, f"{path} with a wrong token")
        check(hands(f"{path}?token={hoist.token}", [("Host", "elsewhere.example")]) == 421, f"{path} under a foreign name")


def the_setting_outlives_the_server():
    allow(True)
    hoist.server.end()
    hoist.start_server()
    until("the server sees the core", lambda: hoist.status()["connected"])
    check(hoist.call("GET", "/tools")[1]["enabled"], "the server has forgotten the setting")


def with_node(name, recovers=False):
    def case():
        allow(True)
        if recovers:
            hoist.epoch = None
            hoist.recover()
            hoist.place_anew()
            hoist.recover()
            hoist.call("DELETE", "/lease")
        try:
            script(name)
        except Failed as error:
            raise Failed(f"{error}; {hoist.status()}") from None

    case.__name__ = name
    return case


def main():
    global hoist
    if not os.path.isdir(os.path.join(os.path.dirname(SCRIPT), "node_modules")):
        print("skipped: npm ci has not run in tests/system/tools")
        return 77
    hoist = Hoist(BIN, None, None)
    hoist.lock_step = True  # a busy computer makes time slow and stops nobody
    return run_hoist("ToolClients", hoist, [
        both_are_closed_until_an_engineer_opens_them,
        the_setting_outlives_the_server,
        with_node("foxglove_topics"),
        with_node("foxglove_examples"),
        with_node("foxglove_parameters"),
        with_node("rosbridge_reads"),
        with_node("foxglove_drives", True),
        with_node("rosbridge_drives", True),
    ])


if __name__ == "__main__":
    sys.exit(main())
