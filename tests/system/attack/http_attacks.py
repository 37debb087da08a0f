"""What a client may do to the HTTP side: break off, malform, smuggle, overfill, be slow, pretend to be another page or another name."""
import json
import random
import threading
import time

from ground import attack, beside, check, until
from wire import Line, WebSocket, answers, request, status_of

REFUSED = set(range(400, 432))
SEED = 20261123
# Needed before anybody is signed in.
OPEN = {"get_openapi", "get_docs", "who_am_i", "sign_in", "set_up"}
# Between two attempts of one attacker: this computer must also be the machine, whose bus must not starve. Without pauses: tests/unit/server.
PAUSE_S = 0.02


def refused(status, what, allowed=REFUSED, or_closed=True):
    check(status in allowed or (or_closed and status == 0), f"{what} was answered {status}")


@attack("walking")
def broken_off_downloads(ground):
    """Exports that end with a reset after the request, after the head or within the body, while two clients list sessions."""
    _, answer = ground.hoist.call("GET", "/sessions")
    numbers = [one["id"] for one in answer.get("items", [])][:4]
    check(numbers, "nothing is recorded although the hoist walks")
    over = threading.Event()
    listed = []

    def list_on(_):
        while not over.is_set():
            listed.append(ground.ask("GET", "/api/v1/sessions", [ground.bearer]))
            time.sleep(PAUSE_S)

    def break_off(_):
        for i in range(300):
            target = f"/api/v1/sessions/{numbers[i % len(numbers)]}/export?format={('csv', 'json', 'events')[i % 3]}"
            try:
                line = Line(ground.port)
                line.send(request(ground.port, "GET", target, [ground.bearer]))
                for _ in range(i % 4):
                    line.read_some(2.0)
                line.reset()
            except OSError:
                pass
            time.sleep(PAUSE_S)

    readers = beside(2, list_on)
    for thread in beside(2, break_off):
        thread.join()
    over.set()
    for thread in readers:
        thread.join()
    check(200 in listed, "no list of sessions was answered meanwhile")
    code, _ = ground.hoist.call("GET", f"/sessions/{numbers[0]}")
    check(code == 200, f"a session afterwards: {code}")


@attack("walking")
def malformed_requests(ground):
    host = f"Host: 127.0.0.1:{ground.port}\r\n".encode()
    for data in (b"\r\n\r\nnonsense\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n" + host + b"\r\n", b"GET / HTTP/1.1\r\nno colon\r\n\r\n",
                 b"GET /\x00 HTTP/1.1\r\n" + host + b"\r\n", b"GET /%zz HTTP/1.1\r\n" + host + b"Connection: close\r\n\r\n",
                 b"GET /%00 HTTP/1.1\r\n" + host + b"Connection: close\r\n\r\n", b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n",
                 b"G\x80T / HTTP/1.1\r\n" + host + b"\r\n", b"GET  / HTTP/1.1\r\n" + host + b"\r\n", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
                 b"CONNECT x:1 HTTP/1.1\r\n" + host + b"Connection: close\r\n\r\n", b"OPTIONS * HTTP/1.1\r\n" + host + b"Connection: close\r\n\r\n",
                 b"POST /api/v1/stop HTTP/1.1\r\n" + host + b"Content-Length: -1\r\n\r\n",
                 b"POST /api/v1/stop HTTP/1.1\r\n" + host + b"Content-Length: 1e3\r\n\r\n",
                 b"POST /api/v1/stop HTTP/1.1\r\n" + host + b"Content-Length: 18446744073709551617\r\n\r\nx"):
        refused(status_of(ground.port, data, 3.0), f"{data[:60]!r}")
    # Mutations of a valid request: any answer except a server error.
    good = bytearray(request(ground.port, "GET", "/api/v1/status", [ground.bearer]))
    chance = random.Random(SEED)
    for _ in range(200):
        data = bytearray(good)
        for _ in range(chance.randint(1, 6)):
            data[chance.randrange(len(data))] = chance.randrange(256)
        status = status_of(ground.port, bytes(data) + b"\r\n\r\n", 2.0)
        check(status < 500, f"{bytes(data)!r} was answered {status}")


@attack("walking")
def smuggled_requests(ground):
    """Bodies with an ambiguous end. One refusal, then the connection closes: later bytes are never a request."""
    inner = request(ground.port, "POST", "/api/v1/stop", [ground.bearer])
    head = f"POST /api/v1/lease HTTP/1.1\r\nHost: 127.0.0.1:{ground.port}\r\nAuthorization: {ground.bearer[1]}\r\nContent-Type: application/json\r\n".encode()
    for what, fields, body in (
        ("length and chunked", b"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n", b"0\r\n\r\n"),
        ("chunked and length", b"Transfer-Encoding: chunked\r\nContent-Length: 5\r\n", b"0\r\n\r\n"),
        ("two lengths", b"Content-Length: 0\r\nContent-Length: 2\r\n", b"{}"),
        ("a list of lengths", b"Content-Length: 0, 2\r\n", b"{}"),
        ("chunked twice in one field", b"Transfer-Encoding: chunked, chunked\r\n", b"2\r\n{}\r\n0\r\n\r\n"),
        ("chunked in two fields", b"Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n", b"2\r\n{}\r\n0\r\n\r\n"),
        ("chunked, then identity", b"Transfer-Encoding: chunked, identity\r\n", b"2\r\n{}\r\n0\r\n\r\n"),
        ("an unknown coding", b"Transfer-Encoding: xchunked\r\n", b"2\r\n{}\r\n0\r\n\r\n"),
        ("gzip before chunked", b"Transfer-Encoding: gzip, chunked\r\n", b"2\r\n{}\r\n0\r\n\r\n"),
        ("a space before the colon", b"Transfer-Encoding : chunked\r\n", b"2\r\n{}\r\n0\r\n\r\n"),
        ("a folded line", b"Transfer-Encoding:\r\n chunked\r\nContent-Length: 2\r\n", b"{}"),
        ("a chunk's size with sign", b"Transfer-Encoding: chunked\r\n", b"+2\r\n{}\r\n0\r\n\r\n"),
        ("a chunk's size with 0x", b"Transfer-Encoding: chunked\r\n", b"0x2\r\n{}\r\n0\r\n\r\n"),
        ("a chunk's size beyond 64 bits", b"Transfer-Encoding: chunked\r\n", b"10000000000000002\r\n{}\r\n0\r\n\r\n"),
        ("a chunk without its end", b"Transfer-Encoding: chunked\r\n", b"2\r\n{}X0\r\n\r\n"),
    ):
        with Line(ground.port) as line:
            line.send(head + fields + b"\r\n" + body + inner)
            found = answers(line.read_all(3.0))
        check(len(found) <= 1, f"{what}: {len(found)} answers, {found}")
        check(not found or found[0] in REFUSED, f"{what}: answered {found}")
    check(ground.hoist.mode() == "user", "a smuggled STOP was carried out")


@attack("walking")
def trailers_as_headers(ground):
    """Fields after a chunked body are no headers: they neither sign in nor grant anything."""
    _, cookie = ground.cookie()

    def chunked(headers, trailers):
        lines = [f"POST /api/v1/lease HTTP/1.1\r\nHost: 127.0.0.1:{ground.port}\r\nConnection: close\r\nContent-Type: application/json"]
        lines += [f"{name}: {value}" for name, value in headers]
        tail = "".join(f"{name}: {value}\r\n" for name, value in trailers)
        return ("\r\n".join(lines) + "\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n" + tail + "\r\n").encode()

    for what, headers, trailers in (("Authorization", [], [ground.bearer]), ("Cookie", [("X-Hoist", "1")], [cookie]),
                                    ("X-Hoist", [cookie], [("X-Hoist", "1")])):
        status = status_of(ground.port, chunked(headers, trailers))
        check(status in (400, 401, 403), f"{what} in a trailer: answered {status}")
    # What is left out of a request must not come in by its trailer either.
    data = (f"POST /api/v1/stop HTTP/1.1\r\nConnection: close\r\nAuthorization: {ground.bearer[1]}\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n"
            f"Host: 127.0.0.1:{ground.port}\r\n\r\n").encode()
    refused(status_of(ground.port, data), "Host in a trailer")
    check(ground.hoist.mode() == "user", "a request without a host was carried out")


@attack("walking")
def json_with_other_bytes(ground):
    """A body is exactly one JSON object, without text before or after it and without repeated fields."""
    before = ground.hoist.call("GET", "/parameters/lean_tau_normal_s")
    for body in (b'{"take_over":true} x', b'{"take_over":true}{}', b'{"take_over":true}\x00', b'{"take_over":true}]', b'{"take_over":true},',
                 b'\xef\xbb\xbf\xef\xbb\xbf{"take_over":true}', b"[" * 60000, b'{"a":' * 5000, b'{"take_over":1e999}', b'{"take_over":NaN}',
                 b'{"take_over":true,"take_over":false}', b"{'take_over':true}", b'{"take_over":true', b'\xff\xfe{\x00}\x00', b'"text"', b"[]", b"null",
                 b'{"take_over":true}//', b'{"take_over":"\\ud800"}'):
        status = ground.ask("POST", "/api/v1/lease", [ground.bearer, ground.json_type], body)
        refused(status, f"{body[:40]!r}", or_closed=False)
    check(ground.hoist.call("GET", "/parameters/lean_tau_normal_s") == before, "a refused body changed a parameter")


@attack("walking")
def oversize_requests(ground):
    head = f"Host: 127.0.0.1:{ground.port}\r\nAuthorization: {ground.bearer[1]}\r\n".encode()
    for what, data, allowed in (
        ("a long header", b"GET / HTTP/1.1\r\n" + head + b"X: " + b"x" * 20000 + b"\r\n\r\n", {431}),
        ("2000 headers", b"GET / HTTP/1.1\r\n" + head + b"X: x\r\n" * 2000 + b"\r\n", {431}),
        ("a long address", b"GET /" + b"x" * 20000 + b" HTTP/1.1\r\n" + head + b"\r\n", {400, 414, 431}),
        ("1000 query fields", b"GET /api/v1/sessions?" + b"a=1&" * 1000 + b" HTTP/1.1\r\n" + head + b"Connection: close\r\n\r\n", REFUSED),
        ("a long body", b"POST /api/v1/lease HTTP/1.1\r\n" + head + b"Content-Length: 70000\r\n\r\n" + b"x" * 70000, {413}),
        ("9e18 bytes announced", b"POST /api/v1/lease HTTP/1.1\r\n" + head + b"Content-Length: 9000000000000000000\r\n\r\n", {413, 400}),
        ("an endless chunked body", b"POST /api/v1/lease HTTP/1.1\r\n" + head + b"Transfer-Encoding: chunked\r\n\r\n" + b"1000\r\n" + b"x" * 4096 +
         b"\r\n" + (b"1000\r\n" + b"x" * 4096 + b"\r\n") * 40, {413}),
        ("a long program for a node", b"POST /api/v1/firmware/drive_left HTTP/1.1\r\n" + head + b"Content-Type: application/octet-stream\r\nContent-Length: "
         b"200000\r\n\r\n" + b"x" * 200000, {413}),
    ):
        with Line(ground.port) as line:
            line.send(data)
            found = answers(line.read_all(5.0))
        check(not found or found[0] in allowed, f"{what}: answered {found}")
    garbage = random.Random(SEED).randbytes(20000)
    status = ground.ask("POST", "/api/v1/firmware/drive_left", [ground.bearer, ("Content-Type", "application/octet-stream")], garbage)
    check(status in (409, 422), f"garbage as a node's program: answered {status}")


@attack("walking")
def slow_and_silent_clients(ground):
    """Sixty headers a byte at a time and a hundred silent connections: signed-in clients still get in, also with STOP."""
    slow = []
    try:
        for _ in range(60):
            slow.append(Line(ground.port))
            slow[-1].send(b"GET / HTTP/1.1\r\nHost: 127")
        for _ in range(100):
            slow.append(Line(ground.port))
        for _ in range(12):
            for line in slow[:60]:
                line.send(b".")
            began = time.monotonic()
            check(ground.ask("GET", "/api/v1/status", [ground.bearer]) == 200, "GET /status was refused meanwhile")
            check(time.monotonic() - began < 2.0, "GET /status had to wait meanwhile")
            time.sleep(0.5)
        until("there is a seat again for a stranger", lambda: ground.ask("GET", "/") in (200, 404), 5.0, 0.5)
    finally:
        for line in slow:
            line.close()


@attack("walking")
def requests_of_another_page(ground):
    """CSRF: the browser sends the cookie by itself, so it must not be enough. `mode` to standby would end the walk."""
    _, cookie = ground.cookie()
    body = b'{"mode":"standby"}'
    epoch = ("X-Hoist-Lease", str(ground.hoist.epoch))
    ours, evil = f"http://127.0.0.1:{ground.port}", "http://evil.example"
    for what, headers in (
        ("no X-Hoist", [cookie, ground.json_type, epoch, ("Origin", ours)]),
        ("a foreign origin", [cookie, ground.json_type, epoch, ("Origin", evil), ("X-Hoist", "1")]),
        ("the origin null", [cookie, ground.json_type, epoch, ("Origin", "null"), ("X-Hoist", "1")]),
        ("another port", [cookie, ground.json_type, epoch, ("Origin", f"http://127.0.0.1:{ground.port + 1}"), ("X-Hoist", "1")]),
        ("a name that begins like ours", [cookie, ground.json_type, epoch, ("Origin", ours + ".evil.example"), ("X-Hoist", "1")]),
        ("a form", [cookie, ("Content-Type", "application/x-www-form-urlencoded"), epoch, ("X-Hoist", "1")]),
        ("plain text", [cookie, ("Content-Type", "text/plain"), epoch]),
    ):
        check(ground.ask("POST", "/api/v1/mode", headers, body) in (403, 415), f"{what} was let through")
    for what, headers in (("a foreign origin", [cookie, ("Origin", evil)]), ("no origin", [cookie]), ("the origin null", [cookie, ("Origin", "null")])):
        with WebSocket(ground.port, headers) as socket:
            check(socket.status == 403, f"a WebSocket with {what}: answered {socket.status}")
    check(ground.ask("GET", "/api/v1/stop", [cookie]) == 405, "GET, which any page can make the browser send, did something")
    check(ground.hoist.mode() == "user", "another page ended the walk")


@attack("walking")
def other_names_for_this_computer(ground):
    """DNS rebinding: a foreign name that points here is not ours."""
    port = ground.port
    for host in ("evil.example", f"evil.example:{port}", "127.0.0.1.evil.example", f"127.0.0.1:{port}@evil.example", "", "[::1].evil", f"127.0.0.1:{port}/", "0x7f.1",
                 f"evil.example, 127.0.0.1:{port}"):
        data = f"GET /api/v1/status HTTP/1.1\r\nHost: {host}\r\nAuthorization: {ground.bearer[1]}\r\nConnection: close\r\n\r\n".encode()
        check(status_of(port, data) in (400, 421), f"the host {host!r} was let in")
    for what, lines in (("no host", ""), ("two hosts", f"Host: 127.0.0.1:{port}\r\nHost: evil.example\r\n")):
        data = f"GET /api/v1/status HTTP/1.1\r\n{lines}Authorization: {ground.bearer[1]}\r\nConnection: close\r\n\r\n".encode()
        check(status_of(port, data) in (400, 421), f"{what}: let in")
    data = f"GET http://evil.example/api/v1/status HTTP/1.1\r\nHost: evil.example\r\nAuthorization: {ground.bearer[1]}\r\nConnection: close\r\n\r\n".encode()
    check(status_of(port, data) in (400, 404, 421), "an address with a foreign name was let in")


@attack("walking")
def guessed_and_stolen_secrets(ground):
    """Without the secret only open routes answer, files outside the console stay there, a link works once."""
    with Line(ground.port) as line:
        line.send(request(ground.port, "GET", "/api/openapi.json"))
        routes = json.loads(line.read_all().partition(b"\r\n\r\n")[2])["paths"]
    chance = random.Random(SEED)
    guess = ("Authorization", "Bearer " + "%064x" % chance.getrandbits(256))
    opened = {operation["operationId"] for methods in routes.values() for operation in methods.values() if operation.get("security") == []}
    check(opened == OPEN, f"the description calls open: {sorted(opened)}")
    for path, methods in routes.items():
        for method, operation in methods.items():
            target = path.replace("{id}", "1").replace("{name}", "lean_tau_normal_s").replace("{node}", "drive_left")
            for headers in ([], [guess]):
                if operation["operationId"] not in OPEN:
                    check(ground.ask(method.upper(), target, headers) == 401, f"{method} {target} without the secret was not answered 401")
                elif method != "get":
                    refused(ground.ask(method.upper(), target, headers), f"{method} {target} without a password")
    for headers in ([], [guess]):
        with Line(ground.port) as line:
            line.send(request(ground.port, "GET", "/api/v1/session", headers))
            who = json.loads(line.read_all().partition(b"\r\n\r\n")[2])
        check(who["signed_in"] is False and who["user"] is None and who["here"] == [], f"a stranger is told {who}")
    token = ground.hoist.token
    for spoilt in (token[:-1], token + "0", token.upper(), token[::-1], "", "*", f"{token}\t{token}"):
        if spoilt != token:
            check(ground.ask("POST", "/api/v1/stop", [("Authorization", f"Bearer {spoilt}")]) in (400, 401), "a spoilt token was taken")
    link, _ = ground.cookie()
    check(ground.ask("GET", f"/?token={link}") == 401, "a used link worked again")
    for target in ("/../token", "/..%2ftoken", "/%2e%2e/token", "/assets/../../token", "//token", "/./../token", "/%2fetc/passwd", "/..%5ctoken", "/\\..\\token"):
        with Line(ground.port) as line:
            line.send(request(ground.port, "GET", target))
            seen = line.read_all(3.0)
        check(token.encode() not in seen and b"root:" not in seen, f"{target} showed a secret")


@attack("walking")
def injected_text(ground):
    """Texts that another language could take for its own: they are stored and shown as they are, or refused."""
    code, answer = ground.hoist.call("GET", "/sessions")
    check(code == 200 and answer["items"], f"{code} {answer}")
    number = answer["items"][-1]["id"]
    for text in ("'; DROP TABLE sessions; --", '"><script>alert(1)</script>', "=HYPERLINK(\"http://evil\")", "line\r\nSet-Cookie: a=b", "a\u0000b", "\u202etxt.exe",
                 "%00%0d%0a", "x" * 4000, "\ud83d\ude00" * 10):
        text = text.encode("utf-16", "surrogatepass").decode("utf-16")
        code, changed = ground.hoist.call("PATCH", f"/sessions/{number}", {"note": text})
        check(code in (200, 422), f"the note {text[:30]!r}: {code}")
        if code == 200:
            check(changed["note"] == text, f"the note {text[:30]!r} was stored as {changed['note'][:30]!r}")
    for query in ("q=%27%20OR%201=1--", "cursor=1%20OR%201", "limit=1;DROP", "limit=-1", "limit=99999999999999999999", "q=%00", "q=" + "x" * 3000):
        status = ground.ask("GET", f"/api/v1/sessions?{query}", [ground.bearer])
        check(status in (200, 400, 422), f"?{query[:40]}: answered {status}")
    for identifier in ("0", "-1", "1e3", "1%00", "9223372036854775808", "..%2f1", "1'"):
        status = ground.ask("GET", f"/api/v1/sessions/{identifier}/export", [ground.bearer])
        check(status in (400, 404), f"session {identifier}: answered {status}")
    until("sessions are still listed", lambda: ground.hoist.call("GET", "/sessions")[0] == 200, 5.0)
