"""HTTPS and WSS with clients of other people: Python's ssl, openssl s_client and Chromium. The server alone, without a core."""
import base64
import json
import os
import re
import shutil
import socket
import ssl
import subprocess
import sys
import tempfile

from harness import Failed, Program, Skipped, check, run, run_suite, until

BIN, TOP = sys.argv[1], sys.argv[2]
folder = tempfile.mkdtemp(prefix="hoist-tls-")
server = None
port = 0


def path(name):
    return os.path.join(folder, name)


def make_certificates():
    for name in ("server", "other"):
        run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj", "/CN=localhost",
            "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1", "-keyout", path(f"{name}.key"), "-out", path(f"{name}.pem"))


def command(key="server.key"):
    return [os.path.join(BIN, "hoist-server"), "--socket", path("core.sock"), "--port", "0", "--db", path("hoist.db"), "--token-file", path("token"),
            "--tls-cert", path("server.pem"), "--tls-key", path(key)]


def start():
    global server, port
    server = Program(folder, "hoist-server", *command())
    server.says("Open https://")
    port = int(re.search(r"Open https://127\.0\.0\.1:(\d+)/", server.output()).group(1))


def token():
    with open(path("token")) as file:
        return file.read().strip()


def connect(context=None, receive_buffer=None):
    line = socket.socket()
    if receive_buffer:
        line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
    line.settimeout(30)
    line.connect(("127.0.0.1", port))
    return (context or trusting()).wrap_socket(line, server_hostname="localhost")


def trusting(version=None):
    context = ssl.create_default_context(cafile=path("server.pem"))
    if version:
        context.minimum_version = context.maximum_version = version
    return context


def ask(line, target, headers=(), keep=False):
    """One request; gives the status, the headers and the body."""
    fields = [f"Host: localhost:{port}", f"Connection: {'keep-alive' if keep else 'close'}", *headers]
    line.sendall((f"GET {target} HTTP/1.1\r\n" + "".join(f"{field}\r\n" for field in fields) + "\r\n").encode())
    got = b""
    while b"\r\n\r\n" not in got:
        piece = line.recv(4096)
        check(piece, f"closed before an answer to {target}: {got!r}")
        got += piece
    head, body = got.split(b"\r\n\r\n", 1)
    lines = head.decode().split("\r\n")
    fields = {name.lower(): value.strip() for name, value in (one.split(":", 1) for one in lines[1:])}
    while len(body) < int(fields.get("content-length", 0)):
        piece = line.recv(4096)
        check(piece, f"closed within the answer to {target}")
        body += piece
    return int(lines[0].split()[1]), fields, body


def signed_in():
    return f"Authorization: Bearer {token()}"


def both_versions_answer_and_older_ones_do_not():
    for version in (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3):
        with connect(trusting(version)) as line:
            check("ECDHE" in line.cipher()[0] or line.version() == "TLSv1.3", f"{line.cipher()} has no forward secrecy")
            for _ in range(3):
                status, _, body = ask(line, "/api/v1/status", [signed_in()], keep=True)
                check(status == 200 and json.loads(body)["version"], f"{line.version()} answers {status}")
    old = trusting()
    old.set_ciphers("DEFAULT:@SECLEVEL=0")
    old.minimum_version = ssl.TLSVersion.TLSv1
    old.maximum_version = ssl.TLSVersion.TLSv1_1
    try:
        connect(old).close()
    except ssl.SSLError:
        return
    raise Failed("TLS 1.1 was accepted")


def openssl_s_client_verifies_the_chain():
    done = subprocess.run(["openssl", "s_client", "-connect", f"127.0.0.1:{port}", "-CAfile", path("server.pem"), "-verify_return_error", "-alpn",
                           "h2,http/1.1", "-servername", "localhost"], input="", capture_output=True, text=True, timeout=60, check=False)
    check("Verify return code: 0 (ok)" in done.stdout, done.stdout[-1500:] + done.stderr[-500:])
    check("ALPN protocol: http/1.1" in done.stdout, "of h2 and http/1.1 the server takes http/1.1")


def a_client_that_offers_only_other_protocols_is_served_without_one():
    for offered in (["h2"], ["h2", "spdy/3", "x" * 255]):
        context = trusting()
        context.set_alpn_protocols(offered)
        with connect(context) as line:
            check(line.selected_alpn_protocol() is None, f"{line.selected_alpn_protocol()} was chosen of {offered}")
            status, _, _ = ask(line, "/api/v1/status", [signed_in()])
            check(status == 200, f"{offered}: {status}")


def a_slow_reader_gets_a_long_answer_whole():
    with open(os.path.join(TOP, "server/contract/openapi.gen.json")) as file:
        paths = json.load(file)["paths"]
    with connect(receive_buffer=2048) as line:
        status, _, body = ask(line, "/api/openapi.json")
    check(status == 200 and json.loads(body)["paths"] == paths, f"{status}, {len(body)} bytes")


def a_long_body_is_read_in_whole_records():
    body = json.dumps({"note": "x" * 60000}).encode()
    with connect() as line:
        line.sendall((f"PATCH /api/v1/sessions/1 HTTP/1.1\r\nHost: localhost:{port}\r\nIf-Match: *\r\nContent-Type: application/json\r\n{signed_in()}\r\n"
                      f"Content-Length: {len(body)}\r\nConnection: close\r\n\r\n").encode() + body)
        answer = line.recv(4096)
    check(answer.split(b" ")[1] in (b"404", b"422", b"503"), f"{answer[:200]}")


def exactly(line, count):
    got = b""
    while len(got) < count:
        piece = line.recv(count - len(got))
        check(piece, "the WebSocket was closed")
        got += piece
    return got


def frame(line):
    opcode, size = exactly(line, 2)
    if size == 126:
        size = int.from_bytes(exactly(line, 2), "big")
    elif size == 127:
        size = int.from_bytes(exactly(line, 8), "big")
    return opcode & 0xF, exactly(line, size)


def upgrade(line):
    key = base64.b64encode(os.urandom(16)).decode()
    line.sendall((f"GET /ws HTTP/1.1\r\nHost: localhost:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n"
                  f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: hoist.v1\r\n{signed_in()}\r\n\r\n").encode())
    head = b""
    while not head.endswith(b"\r\n\r\n"):
        head += exactly(line, 1)
    check(head.startswith(b"HTTP/1.1 101 "), f"{head[:200]}")


def websocket_frames_come_whole_and_in_order_to_a_client_that_reads_late():
    count = 1500
    with connect(receive_buffer=2048) as line:
        upgrade(line)
        kind, text = frame(line)
        check(kind == 1 and json.loads(text)["type"] == "welcome", f"{kind} {text[:100]}")
        # More than the kernel and TLS hold: the server must wait in the middle of a record, and go on there.
        for number in range(count):
            payload = f"{number:0125d}".encode()
            line.sendall(bytes([0x89, 0x80 | len(payload), 0, 0, 0, 0]) + payload)
        expected = 0
        while expected < count:
            kind, payload = frame(line)
            if kind == 0xA:
                check(int(payload) == expected, f"pong {payload} instead of {expected}")
                expected += 1


def frames_that_came_in_one_record_are_all_answered():
    # Longer than one read of the server: the rest is already decrypted, so the socket is not readable any more.
    count = 60
    with connect() as line:
        upgrade(line)
        line.sendall(b"".join(bytes([0x89, 0x80 | 125, 0, 0, 0, 0]) + f"{number:0125d}".encode() for number in range(count)))
        expected = 0
        while expected < count:
            kind, payload = frame(line)
            if kind == 0xA:
                check(int(payload) == expected, f"pong {payload} instead of {expected}")
                expected += 1


def a_plain_request_is_not_answered_and_disturbs_no_other_client():
    with socket.create_connection(("127.0.0.1", port), 30) as line:
        line.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
        got = b""
        try:
            while piece := line.recv(4096):
                got += piece
        except ConnectionResetError:
            pass
    check(b"HTTP/1" not in got, f"{got!r}")
    with connect() as line:
        check(ask(line, "/api/docs")[0] == 200, "the next client is served")


def the_link_gives_a_cookie_for_this_host_only():
    link = until("a fresh link", lambda: re.findall(r"Open https://\S+/\?token=(\S+)", server.output()))[-1]
    with connect() as line:
        status, fields, _ = ask(line, f"/?token={link}")
    check(status == 303, f"{status}")
    cookie = fields["set-cookie"]
    check(cookie.startswith("__Host-hoist_session=") and "Secure" in cookie and "Path=/" in cookie and "Domain" not in cookie, cookie)
    with connect() as line:
        check(ask(line, "/api/v1/status", [f"Cookie: {cookie.split(';')[0]}"])[0] == 200, "the cookie signs in")
    with connect() as line:
        status, _, _ = ask(line, "/api/v1/status", [f"Cookie: {cookie.split(';')[0]}", f"Origin: http://localhost:{port}"])
        check(status == 403, f"a plain page of the same host gets {status}")


def chromium_opens_it():
    program = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    if program is None:
        raise Skipped("no chromium on this machine")
    public = run("sh", "-c", f"openssl x509 -in {path('server.pem')} -pubkey -noout | openssl pkey -pubin -outform der | openssl dgst -sha256 -binary | base64")
    page = subprocess.run([program, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={path('chromium')}",
                           f"--ignore-certificate-errors-spki-list={public.strip()}", "--dump-dom", f"https://localhost:{port}/api/docs"],
                          capture_output=True, text=True, timeout=120, check=False)
    check("<h1>Hoist API</h1>" in page.stdout, page.stdout[-500:] + page.stderr[-500:])


def what_cannot_be_used_is_refused_with_a_sentence():
    for key, mode, words in (("other.key", 0o600, "does not belong to the certificate"), ("server.key", 0o644, "chmod 600"), ("none.key", None, "cannot be read")):
        if mode is not None:
            os.chmod(path(key), mode)
        try:
            done = subprocess.run([*command(key), "--db", path("refused.db")], capture_output=True, text=True, timeout=60, check=False)
        finally:
            if mode is not None:
                os.chmod(path(key), 0o600)
        check(done.returncode == 1 and words in done.stderr, f"{key}: {done.returncode} {done.stderr}")


def main():
    make_certificates()
    start()
    try:
        return run_suite("TlsClients", [
            both_versions_answer_and_older_ones_do_not,
            openssl_s_client_verifies_the_chain,
            a_client_that_offers_only_other_protocols_is_served_without_one,
            a_slow_reader_gets_a_long_answer_whole,
            a_long_body_is_read_in_whole_records,
            websocket_frames_come_whole_and_in_order_to_a_client_that_reads_late,
            frames_that_came_in_one_record_are_all_answered,
            a_plain_request_is_not_answered_and_disturbs_no_other_client,
            the_link_gives_a_cookie_for_this_host_only,
            chromium_opens_it,
            what_cannot_be_used_is_refused_with_a_sentence,
        ])
    finally:
        server.end()


if __name__ == "__main__":
    sys.exit(main())
