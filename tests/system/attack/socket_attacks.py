"""Attacks on the WebSocket: protocol violations, floods, taking every seat, never reading."""
import contextlib
import json
import threading
import time

from ground import attack, beside, check, until
from wire import request, answers, frame_bytes, Line

PROTOCOL, NOT_TEXT, BAD_UTF8, POLICY, TOO_BIG = 1002, 1003, 1007, 1008, 1009
SEATS = 64  # of the server; all of one address here


@attack("walking")
def broken_websocket_frames(ground):
    """Each is closed with its code, and its content is not executed: half of them hold a STOP."""
    stop = json.dumps({"type": "stop"}).encode()
    mask = b"\x5a\xc3\x0f\x99"
    masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(stop))
    for what, frames, codes in (
        ("unmasked", [(0x81, stop, None)], {PROTOCOL}),
        ("a reserved bit", [(0xC1, stop, mask)], {PROTOCOL}),
        ("a reserved opcode", [(0x83, stop, mask)], {PROTOCOL}),
        ("a reserved control opcode", [(0x8B, stop, mask)], {PROTOCOL}),
        ("a continuation of nothing", [(0x80, stop, mask)], {PROTOCOL}),
        ("text within text", [(0x01, b'{"type":', mask), (0x81, stop, mask)], {PROTOCOL}),
        ("a fragmented ping", [(0x09, b"a", mask)], {PROTOCOL}),
        ("a long ping", [(0x89, b"a" * 126, mask)], {PROTOCOL}),
        ("binary", [(0x82, stop, mask)], {NOT_TEXT}),
        ("bytes that are no text", [(0x81, b"\xff\xfe\xed\xa0\x80", mask)], {BAD_UTF8}),
        ("a long message", [(0x81, b" " * 5000, mask)], {TOO_BIG}),
        ("a long message in parts", [(0x01, b" " * 3000, mask), (0x80, b" " * 3000, mask)], {TOO_BIG}),
        ("no JSON", [(0x81, b"stop", mask)], {POLICY}),
        ("JSON and more", [(0x81, stop + b" stop", mask)], {POLICY}),
        ("no object", [(0x81, b'["stop"]', mask)], {POLICY}),
        ("deep nesting", [(0x81, b"[" * 4000, mask)], {POLICY}),
        ("a close of one byte", [(0x88, b"x", mask)], {PROTOCOL}),
        ("a close with code 1005", [(0x88, b"\x03\xed", mask)], {PROTOCOL}),
    ):
        with ground.live() as socket:
            for first, payload, key in frames:
                socket.frame(first, payload, key)
            code = socket.close_code(3.0)
            check(code in codes, f"{what}: closed with {code}, not {codes}")
    for what, data in (("a length that is not the shortest", b"\x81\xfe\x00\x05" + mask + b"hello"), ("2^63 bytes announced", b"\x81\xff" + b"\xff" * 8 + mask),
                       ("half a frame, then the end", b"\x81" + bytes([0x80 | len(stop)]) + mask + masked[:5])):
        with ground.live() as socket:
            socket.send(data)
            if "half" in what:
                socket.reset()
            else:
                code = socket.close_code(3.0)
                check(code in (PROTOCOL, TOO_BIG), f"{what}: closed with {code}")
    for what, headers in (("no key", [ground.bearer, ("Sec-WebSocket-Key", "x")]), ("another version", [ground.bearer, ("Sec-WebSocket-Version", "8")])):
        data = request(ground.port, "GET", "/ws", [("Upgrade", "websocket"), ("Sec-WebSocket-Protocol", "hoist.v1")] + headers)
        with Line(ground.port) as line:
            line.send(data)
            found = answers(line.read_all(3.0))
        check(not found or 400 <= found[0] < 500, f"a handshake with {what}: answered {found}")
    check(ground.hoist.mode() == "user", "a STOP from a broken frame was carried out")


@attack("stopped")
def a_flood_of_messages_with_a_stop_in_it(ground):
    """Six sockets send as fast as they can. They are closed for it, and a STOP behind the flood of one of them still stops the walk."""
    ground.walk()
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(ground.live()) for _ in range(6)]
        for _ in range(200):
            for i, socket in enumerate(sockets[:3]):
                socket.frame(0x81, b'{"type":"ping","t":1}' if i else b'{"type":"nonsense"}')
        for socket in sockets[3:5]:
            for _ in range(2000):
                if not socket.frame(0x89, b"x" * 100):
                    break
        for socket in sockets[:3]:
            check(socket.close_code(5.0) in (POLICY, 0), "a flood was not closed")
        check(ground.hoist.mode() == "user", f"the flood itself ended the walk: mode {ground.hoist.mode()}")
        # The allowance of one second, then STOP: it is read before anything is counted.
        for _ in range(60):
            sockets[5].say(type="ping", t=1)
        sockets[5].say(type="stop")
        until("the STOP behind the flood stops the hoist", lambda: ground.hoist.mode() == "protective_stop", 2.0, 0.02)


@attack("stopped")
def a_flood_of_stops(ground):
    """One socket sends STOP as fast as it can. Meanwhile the core answers what another client asks."""
    ground.walk()
    stops = frame_bytes(0x81, b'{"type":"stop"}') * 1000
    with ground.live() as flood, ground.live() as other:
        ending = threading.Event()

        def stop_on():
            while not ending.is_set() and flood.send(stops):
                pass

        threads = beside(1, lambda _: stop_on())
        try:
            until("the flood stops the hoist", lambda: ground.hoist.mode() == "protective_stop", 2.0, 0.02)
            for number in range(1, 21):
                other.say(type="lease_take", request=number)
                reply = other.reply(number)
                check(reply.get("refusals") == ["no_lease"], f"beside the flood the core did not hear question {number}: {reply}")
        finally:
            ending.set()
            for thread in threads:
                thread.join()


@attack("stopped")
def every_seat_taken_by_websockets_of_one_address(ground):
    """As many signed-in WebSockets as the server admits, then a STOP on a connection of its own."""
    ground.walk()
    with contextlib.ExitStack() as stack:
        sockets = []
        while len(sockets) < SEATS + 8:
            try:
                sockets.append(stack.enter_context(ground.live()))
            except Exception:  # pylint: disable=broad-except
                break
        check(len(sockets) >= 8, f"only {len(sockets)} WebSockets were admitted")
        for attempt in range(3):
            status = ground.ask("POST", "/api/v1/stop", [ground.bearer])
            check(status == 200, f"STOP number {attempt + 1} beside {len(sockets)} WebSockets was answered {status}")
        until("the hoist stops", lambda: ground.hoist.truth()["speed_m_s"] < 0.01, 3.0, 0.05)


@attack("walking")
def clients_that_never_read(ground):
    """They lose values, then their connection; the server's memory does not follow them."""

    def memory_kb():
        with open(f"/proc/{ground.hoist.server.process.pid}/status") as file:
            return int(next(line for line in file if line.startswith("VmRSS")).split()[1])

    before_kb = memory_kb()
    with contextlib.ExitStack() as stack:
        sockets = [stack.enter_context(ground.live(receive_bytes=4096)) for _ in range(10)]
        end = time.monotonic() + 6.0
        while time.monotonic() < end:
            for socket in sockets:
                socket.frame(0x81, b'{"type":"ping","t":1}')
            check(ground.ask("GET", "/api/v1/status", [ground.bearer]) == 200, "GET /status was refused meanwhile")
            time.sleep(0.1)
    grown_kb = memory_kb() - before_kb
    check(grown_kb < 16 * 1024, f"the server grew by {grown_kb} kB")
