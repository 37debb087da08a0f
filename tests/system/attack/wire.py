"""Bytes as an attacker sends them: raw HTTP and raw WebSocket frames. No client library, because libraries repair what is meant to be wrong."""
import base64
import json
import os
import socket
import struct
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
from harness import Failed  # noqa: E402

LIMIT_S = 10.0
MASK = b"\x5a\xc3\x0f\x99"


class Line:
    """One connection to the server."""

    def __init__(self, port, limit_s=LIMIT_S):
        self.port = port
        self.socket = socket.create_connection(("127.0.0.1", port), limit_s)
        self.buffer = b""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def send(self, data):
        """False when the server has closed."""
        try:
            self.socket.sendall(data)
            return True
        except OSError:
            return False

    def read_some(self, within_s):
        """False at the end, or at the timeout."""
        self.socket.settimeout(max(within_s, 0.001))
        try:
            piece = self.socket.recv(262144)
        except OSError:
            return False
        self.buffer += piece
        return piece != b""

    def read_until(self, mark, within_s=LIMIT_S):
        end = time.monotonic() + within_s
        while mark not in self.buffer:
            if time.monotonic() > end or not self.read_some(end - time.monotonic()):
                return None
        head, _, self.buffer = self.buffer.partition(mark)
        return head

    def read_all(self, within_s=LIMIT_S):
        """Everything until the server closes or falls silent."""
        end = time.monotonic() + within_s
        while time.monotonic() < end and self.read_some(end - time.monotonic()):
            pass
        return self.buffer

    def reset(self):
        """Breaks off at once, without a farewell."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.socket.close()

    def close(self):
        self.socket.close()


def request(port, method, target, headers=(), body=b"", host=None):
    """The bytes of a correct request that asks the server to close afterwards."""
    lines = [f"{method} {target} HTTP/1.1", f"Host: {host or f'127.0.0.1:{port}'}", "Connection: close"]
    lines += [f"{name}: {value}" for name, value in headers]
    if body or method in ("POST", "PUT", "PATCH"):
        lines.append(f"Content-Length: {len(body)}")
    return "\r\n".join(lines).encode("latin-1") + b"\r\n\r\n" + body


def answers(data):
    """The status of every answer in what the server sent."""
    found, at = [], 0
    while True:
        at = data.find(b"HTTP/1.1 ", at)
        if at < 0:
            return found
        if at == 0 or data[at - 1:at] in (b"\n", b"}", b">") or data[at - 2:at] == b"\r\n":
            found.append(int(data[at + 9:at + 12]))
        at += 9


def status_of(port, data, within_s=LIMIT_S):
    """Sends this and returns the first status, 0 when the server closed without an answer."""
    with Line(port) as line:
        line.send(data)
        found = answers(line.read_all(within_s))
        return found[0] if found else 0


def ask(port, method, target, headers=(), body=b"", host=None):
    return status_of(port, request(port, method, target, headers, body, host))


def frame_bytes(first, payload, mask=MASK):
    """One frame of a WebSocket; `first` is its first byte, `mask` None leaves it unmasked."""
    size = len(payload)
    masked = 0x80 if mask is not None else 0
    if size < 126:
        head = bytes([first, masked | size])
    elif size < 65536:
        head = bytes([first, masked | 126]) + struct.pack(">H", size)
    else:
        head = bytes([first, masked | 127]) + struct.pack(">Q", size)
    if mask is None:
        return head + payload
    return head + mask + bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload))


class WebSocket(Line):
    """After a correct handshake, unless `headers` spoil it; `status` is the handshake's."""

    def __init__(self, port, headers, receive_bytes=None, target="/ws"):
        super().__init__(port)
        if receive_bytes is not None:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_bytes)
        key = base64.b64encode(os.urandom(16)).decode()
        lines = [f"GET {target} HTTP/1.1", f"Host: 127.0.0.1:{port}", "Upgrade: websocket", "Connection: Upgrade", f"Sec-WebSocket-Key: {key}",
                 "Sec-WebSocket-Version: 13", "Sec-WebSocket-Protocol: hoist.v1"]
        lines += [f"{name}: {value}" for name, value in headers]
        self.send("\r\n".join(lines).encode() + b"\r\n\r\n")
        head = self.read_until(b"\r\n\r\n")
        self.status = int(head[9:12]) if head else 0

    def frame(self, first, payload, mask=MASK):
        return self.send(frame_bytes(first, payload, mask))

    def say(self, **message):
        return self.frame(0x81, json.dumps(message).encode())

    def next_frame(self, within_s=LIMIT_S):
        """(opcode, payload), or None at the end."""
        end = time.monotonic() + within_s
        while True:
            head = 2
            if len(self.buffer) >= 2:
                size = self.buffer[1] & 0x7F
                if size == 126 and len(self.buffer) >= 4:
                    head, size = 4, struct.unpack(">H", self.buffer[2:4])[0]
                elif size == 127 and len(self.buffer) >= 10:
                    head, size = 10, struct.unpack(">Q", self.buffer[2:10])[0]
                elif size >= 126:
                    size = None
                if size is not None and len(self.buffer) >= head + size:
                    opcode, payload = self.buffer[0] & 0x0F, self.buffer[head:head + size]
                    self.buffer = self.buffer[head + size:]
                    return opcode, payload
            if time.monotonic() > end or not self.read_some(end - time.monotonic()):
                return None

    def close_code(self, within_s=LIMIT_S):
        """Reads on until the server's close frame; 0 when it closed without one, None when it did not close."""
        end = time.monotonic() + within_s
        while time.monotonic() < end:
            got = self.next_frame(end - time.monotonic())
            if got is None:
                return 0 if time.monotonic() < end else None
            if got[0] == 8:
                return struct.unpack(">H", got[1][:2])[0] if len(got[1]) >= 2 else 0
        return None

    def reply(self, number, within_s=LIMIT_S):
        end = time.monotonic() + within_s
        while True:
            got = self.next_frame(end - time.monotonic())
            if got is None or time.monotonic() > end:
                raise Failed(f"no reply to message {number} on the WebSocket")
            if got[0] == 1:
                message = json.loads(got[1])
                if message.get("type") == "reply" and message.get("request") == number:
                    return message
