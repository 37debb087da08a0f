"""A therapist's tablet in a few lines: takes the lease over the WebSocket, starts REMOTE and holds the stick."""
import base64
import json
import os
import socket
import struct
import threading
import time

from harness import Failed, until

EVERY_S = 0.04  # commands come at 25 Hz while held
TIME_AT = 8  # of time_ns in a sample: behind the tick, both 64 bits
HEADER = struct.Struct("<BBHIQ")


class Driver:
    """Connects at once. Reading and driving run in their own threads until close()."""

    def __init__(self, port, token):
        self.line = socket.create_connection(("127.0.0.1", port), 10)
        key = base64.b64encode(os.urandom(16)).decode()
        self.line.sendall((f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n"
                           f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: hoist.v1\r\nAuthorization: Bearer {token}\r\n\r\n").encode())
        self.buffer = b""
        head = self.until_bytes(b"\r\n\r\n")
        if b" 101 " not in head.split(b"\r\n")[0]:
            raise Failed(f"no WebSocket: {head[:200]}")
        self.line.settimeout(None)
        self.lock = threading.Lock()
        self.replies, self.requests = {}, 0
        self.newest_ns, self.sequence = 0, 0
        self.stick = None  # (speed, yaw) while hold-to-run is held
        self.ended = False
        threading.Thread(target=self.read_on, daemon=True).start()
        threading.Thread(target=self.drive_on, daemon=True).start()

    def until_bytes(self, mark):
        while mark not in self.buffer:
            piece = self.line.recv(65536)
            if not piece:
                raise Failed("the server closed the connection")
            self.buffer += piece
        at = self.buffer.index(mark) + len(mark)
        head, self.buffer = self.buffer[:at], self.buffer[at:]
        return head

    def exactly(self, count):
        while len(self.buffer) < count:
            piece = self.line.recv(262144)
            if not piece:
                raise ConnectionError
            self.buffer += piece
        data, self.buffer = self.buffer[:count], self.buffer[count:]
        return data

    def read_on(self):
        try:
            while not self.ended:
                kind, size = self.exactly(2)
                size &= 0x7F
                if size == 126:
                    size = struct.unpack(">H", self.exactly(2))[0]
                elif size == 127:
                    size = struct.unpack(">Q", self.exactly(8))[0]
                data = self.exactly(size)
                if kind & 0x0F == 2 and size > HEADER.size:
                    _, _, _, sample, _ = HEADER.unpack_from(data)
                    self.newest_ns = struct.unpack_from("<Q", data, size - sample + TIME_AT)[0]
                elif kind & 0x0F == 1:
                    message = json.loads(data)
                    if message.get("type") == "reply":
                        self.replies[message["request"]] = message
                elif kind & 0x0F == 9:
                    self.send_frame(0x8A, data)
        except OSError:
            pass

    def send_frame(self, kind, data):
        mask = os.urandom(4)
        size = len(data)
        head = bytes([kind, 0x80 | size]) if size < 126 else bytes([kind, 0x80 | 126]) + struct.pack(">H", size)
        body = bytes(byte ^ mask[i % 4] for i, byte in enumerate(data))
        with self.lock:
            self.line.sendall(head + mask + body)

    def send(self, **message):
        self.send_frame(0x81, json.dumps(message).encode())

    def ask(self, **message):
        self.requests += 1
        number = self.requests
        self.send(request=number, **message)
        return until(f"the reply to {message['type']}", lambda: self.replies.get(number), 10.0, 0.02)

    def drive_on(self):
        held = False
        while not self.ended:
            stick = self.stick
            if stick is not None or held:
                speed, yaw = stick or (0.0, 0.0)
                held = stick is not None
                self.sequence += 1
                try:
                    self.send(type="drive", sequence=self.sequence, echo=self.newest_ns, speed=speed, yaw=yaw, held=held)
                except OSError:
                    return
            time.sleep(EVERY_S)

    def start(self):
        """REMOTE, standing: the stick in the middle."""
        until("telemetry", lambda: self.newest_ns, 10.0, 0.05)
        for message in ({"type": "lease_take", "take_over": True}, {"type": "mode", "mode": "remote", "exercise": {"shape": "free"}}):
            if message["type"] == "mode":
                message["echo"] = self.newest_ns
            reply = self.ask(**message)
            if not reply["ok"]:
                raise Failed(f"{message['type']}: {reply}")

    def hold(self, speed, yaw=0.0):
        self.stick = (0.0, 0.0)
        time.sleep(3 * EVERY_S)  # pressed in the middle first
        self.stick = (speed, yaw)

    def close(self):
        self.ended = True
        self.line.close()
