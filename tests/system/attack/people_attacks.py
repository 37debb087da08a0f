"""Attacks on accounts: guessing, tickets and cookies used twice or by others, more connections than there are seats."""
import contextlib
import json
import re
import statistics
import time

from ground import attack, beside, check, until
from wire import Line, WebSocket, request

PASSWORD = "four words not together"
GUESSES, MINUTE_S, CALLERS = 1000, 60.0, 4


def account(ground, name, role="therapist"):
    """Adds the account once; it stays for the other attacks."""
    code, answer = ground.hoist.call("POST", "/users", {"user": name, "display_name": name, "role": role, "password": PASSWORD})
    check(code in (201, 422), f"{code} {answer}")


def page(ground):
    return [("X-Hoist", "1"), ("Origin", f"http://127.0.0.1:{ground.port}"), ground.json_type]


def call(ground, method, target, headers, body=b""):
    with Line(ground.port) as line:
        line.send(request(ground.port, method, target, headers, body))
        head, _, content = line.read_all().partition(b"\r\n\r\n")
    return int(head[9:12]) if head else 0, head, content


def sign_in(ground, name, password, headers=()):
    status, head, content = call(ground, "POST", "/api/v1/session", [*page(ground), *headers], json.dumps({"user": name, "password": password}).encode())
    found = re.search(rb"Set-Cookie: (hoist_session=[0-9a-f]+)", head)
    return status, ("Cookie", found.group(1).decode()) if found else None, content


def signed_in(ground, name):
    def ask():
        status, cookie, _ = sign_in(ground, name, PASSWORD)
        check(status in (200, 429, 503), f"{status}")
        return cookie

    return until(f"{name} is signed in", ask, 75.0, 0.5)


@attack("walking")
def tickets_and_cookies_used_by_others(ground):
    """A ticket opens one WebSocket, of its own sign-in; a signed-out cookie stops and does nothing else."""
    for name in ("anna", "bert"):
        account(ground, name)
    anna, bert = signed_in(ground, "anna"), signed_in(ground, "bert")
    origin = ("Origin", f"http://127.0.0.1:{ground.port}")

    def ticket(cookie):
        status, _, content = call(ground, "POST", "/api/v1/ws-ticket", [*page(ground), cookie], b"{}")
        check(status == 200, f"a ticket: {status}")
        return json.loads(content)["ticket"]

    def handshake(cookie, text):
        with WebSocket(ground.port, [cookie, origin], target=f"/ws?ticket={text}") as socket:
            return socket.status

    text = ticket(anna)
    check(handshake(bert, text) == 403, "another person's ticket was taken")
    check(handshake(anna, text) == 403, "a ticket was good after somebody else had tried it")
    text = ticket(anna)
    check(handshake(anna, text) == 101, "its own ticket was refused")
    for _ in range(20):
        check(handshake(anna, text) == 403, "a used ticket was taken once more")
    for spoilt in ("", "0" * 64, text.upper(), text[:-1], text + "0"):
        check(handshake(anna, spoilt) == 403, f"the ticket {spoilt!r} was taken")
    check(call(ground, "DELETE", "/api/v1/session", [*page(ground)[:2], bert])[0] == 200, "signing out")
    check(call(ground, "GET", "/api/v1/status", [bert])[0] == 401, "a signed-out cookie still reads")
    check(call(ground, "POST", "/api/v1/lease", [*page(ground), bert], b"{}")[0] == 401, "a signed-out cookie still acts")
    check(ground.hoist.mode() == "user", f"mode {ground.hoist.mode()}")


@attack("walking")
def a_thousand_sign_ins_a_minute(ground):
    """Guesses under many names as fast as they are answered: a handful is tried at all, the walk goes on, and the owner's browser still signs in."""
    account(ground, "anna")
    cookie = signed_in(ground, "anna")
    counts, times_s = {}, []
    end = time.monotonic() + MINUTE_S

    def guess(number):
        for i in range(GUESSES // CALLERS):
            if time.monotonic() > end:
                return
            began = time.monotonic()
            status, _, _ = sign_in(ground, ("anna", "erika", f"user{i}", "admin")[number], f"wrong password {number} {i}")
            times_s.append(time.monotonic() - began)
            counts[status] = counts.get(status, 0) + 1
            time.sleep(0.02)

    threads = beside(CALLERS, guess)
    slowest_s = 0.0
    while any(thread.is_alive() for thread in threads):
        began = time.monotonic()
        check(ground.ask("GET", "/api/v1/status", [ground.bearer]) == 200, "GET /status was refused meanwhile")
        slowest_s = max(slowest_s, time.monotonic() - began)
        time.sleep(0.2)
    for thread in threads:
        thread.join()
    check(set(counts) <= {401, 429, 503}, f"{counts}")
    check(sum(counts.values()) >= GUESSES // 2, f"only {counts} in a minute")
    # Five failures a minute of one address.
    check(counts.get(401, 0) <= 12, f"{counts}: too many guesses were tried")
    check(slowest_s < 1.0, f"GET /status took {slowest_s:.1f} s")
    check(call(ground, "GET", "/api/v1/status", [cookie])[0] == 200, "the owner's sign-in has ended")
    ground.note(f"{counts}, median {statistics.median(times_s) * 1e3:.0f} ms, longest GET /status {slowest_s * 1e3:.0f} ms")


@attack("stopped")
def five_hundred_sockets(ground):
    """500 connections of one address, half of them asking for WebSockets without a secret. Signed-in clients come in, and STOP stops."""
    ground.walk()
    with contextlib.ExitStack() as stack:
        lines = []
        for i in range(500):
            line = stack.enter_context(Line(ground.port))
            if i % 2:
                line.send(request(ground.port, "GET", "/ws", [("Upgrade", "websocket"), ("Sec-WebSocket-Protocol", "hoist.v1")]))
            lines.append(line)
        longest_s = 0.0
        for _ in range(20):
            began = time.monotonic()
            check(ground.ask("GET", "/api/v1/status", [ground.bearer]) == 200, "GET /status was refused meanwhile")
            longest_s = max(longest_s, time.monotonic() - began)
        check(longest_s < 1.0, f"GET /status took {longest_s:.1f} s")
        check(ground.ask("POST", "/api/v1/stop", [ground.bearer]) == 200, "STOP beside 500 sockets")
        until("the hoist stops", lambda: ground.hoist.truth()["speed_m_s"] < 0.01, 3.0, 0.05)
    ground.note(f"longest GET /status {longest_s * 1e3:.0f} ms")
