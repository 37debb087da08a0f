"""--bind: what other devices reach, before and after the first account. A network of its own: the server in one network namespace, the tablet in
another, a cable between them. The server alone."""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from harness import Failed, Program, Skipped, check, run, run_suite, until

BIN = sys.argv[1]
INSIDE = "HOIST_OWN_NETWORK"
NAME, HERE, TABLET, SUBNET = "hoist.local", "192.168.77.5", "192.168.77.9", "192.168.77.0/24"
PASSWORD = "four words not together"
base = tempfile.mkdtemp(prefix="hoist-devices-")
folder = base
tablet = None  # a process in the tablet's network namespace


def path(*names):
    return os.path.join(folder, *names)


def enter_own_network():
    """Starts this file once more in a new network namespace; None where the machine forbids that."""
    for options in (["-n"], ["-r", "-n"]):
        if subprocess.run(["unshare", *options, "ip", "link", "set", "lo", "up"], capture_output=True, check=False).returncode == 0:
            return subprocess.run(["unshare", *options, sys.executable, *sys.argv], env={**os.environ, INSIDE: "1"}, check=False).returncode
    return None


def lay_cable():
    global tablet
    run("ip", "link", "set", "lo", "up")
    tablet = subprocess.Popen(["unshare", "-n", "sleep", "600"])
    mine = os.readlink("/proc/self/ns/net")
    until("the tablet has a network of its own", lambda: os.readlink(f"/proc/{tablet.pid}/ns/net") != mine)
    run("ip", "link", "add", "cable", "type", "veth", "peer", "name", "wifi", "netns", str(tablet.pid))
    run("ip", "addr", "add", f"{HERE}/24", "dev", "cable")
    run("ip", "link", "set", "cable", "up")
    for words in ("addr add " + TABLET + "/24 dev wifi", "link set wifi up", "link set lo up"):
        run("nsenter", "-t", str(tablet.pid), "-n", "ip", *words.split())


def begin_anew():
    """Files of their own for each case and each try."""
    global folder
    folder = tempfile.mkdtemp(dir=base)


class Server:
    def __init__(self, *options):
        self.program = Program(folder, "hoist-server", os.path.join(BIN, "hoist-server"), "--socket", path("core.sock"), "--port", "0", "--http-port", "0", "--db",
                               path("hoist.db"), "--token-file", path("token"), "--tls-dir", path("tls"), "--host", NAME, "--subnet", SUBNET, *options)
        self.program.says("Open https://")
        output = self.program.output()
        self.link = re.search(r"Open (https://\S+)", output).group(1)
        self.port = int(re.search(r"Open https://\S+?:(\d+)/\?token", output).group(1))
        self.plain_port = int(re.search(r"How to trust it: http://[^:]*:(\d+)/", output).group(1))

    def ask(self, target, *options, host=NAME, elsewhere=True, plain=False):
        """(status, header fields, body) as curl gets them, from the tablet or from this computer. It trusts the hoist's authority only."""
        port = self.plain_port if plain else self.port
        place = ["nsenter", "-t", str(tablet.pid), "-n"] if elsewhere else []
        url = target if "://" in target else f"{'http' if plain else 'https'}://{host}:{port}{target}"
        done = subprocess.run([*place, "curl", "--silent", "--show-error", "--max-time", "20", "--include", "--cacert", path("ca.pem"), "--connect-to",
                               f"{NAME}:{port}:{HERE}:{port}", *options, url], capture_output=True, text=True, errors="replace", timeout=60, check=False)
        # A WebSocket's handshake is answered, then nothing more comes.
        if done.returncode not in (0, 28):
            raise Failed(f"curl {url}: {done.returncode} {done.stderr}")
        head, _, body = done.stdout.partition("\n\n")
        lines = head.splitlines()
        return int(lines[0].split()[1]), {line.partition(":")[0].lower(): line.partition(":")[2].strip() for line in lines[1:]}, body

    def end(self):
        self.program.end()


def page(server, host=NAME, *more):
    return ["-H", "X-Hoist: 1", "-H", f"Origin: https://{host}:{server.port}", *more]


def name_of(answer):
    return json.loads(answer[2])["type"].rpartition("/")[2]


def what_cannot_be_used_is_refused_with_a_sentence():
    for more, words in ((["--bind", "0.0.0.0"], "add --tls-dir"), (["--bind", HERE], "add --tls-dir"), (["--bind", "hoist.local", "--tls-dir", path("tls")], "no address"),
                        (["--bind", "192.168.78.1", "--tls-dir", path("tls-other")], "ip address")):
        done = subprocess.run([os.path.join(BIN, "hoist-server"), "--socket", path("core.sock"), "--port", "0", "--db", path("refused.db"), *more], capture_output=True,
                              text=True, timeout=60, check=False)
        check(done.returncode in (1, 2) and words in done.stderr, f"{more}: {done.returncode} {done.stderr}")


def other_devices_set_the_hoist_up_and_sign_in():
    begin_anew()
    server = Server("--bind", "0.0.0.0")
    try:
        trust(server)
        with open(path("token")) as file:
            token = ["-H", f"Authorization: Bearer {file.read().strip()}"]
        before_the_first_account(server, token)
        run("sh", "-c", f"echo '{PASSWORD}' | {os.path.join(BIN, 'hoist')} user add {path('accounts.db')} anna 'Anna Weber' engineer")
        until("the server knows the account", lambda: not json.loads(server.ask("/api/v1/session")[2])["set_up"]["needed"])
        cookie = signed_in(server)
        names_and_origins(server, cookie)
        this_computer_keeps_its_own_way(server, token)
    finally:
        server.end()


def trust(server):
    """The way of a new tablet: plain page, certificate, HTTPS."""
    done = subprocess.run(["nsenter", "-t", str(tablet.pid), "-n", "curl", "--silent", "--fail", "-H", f"Host: {NAME}", "--output", path("ca.der"),
                           f"http://{HERE}:{server.plain_port}/hoist-authority.crt"], capture_output=True, text=True, timeout=60, check=False)
    check(done.returncode == 0, f"the certificate: {done.returncode} {done.stderr}")
    run("openssl", "x509", "-inform", "der", "-in", path("ca.der"), "-out", path("ca.pem"))
    check(server.ask("/", plain=True)[0] == 200, "the page that explains it")


def before_the_first_account(server, token):
    status, _, body = server.ask("/api/v1/session")
    check(status == 200 and json.loads(body)["set_up"]["needed"], f"the set-up: {status} {body}")
    check(server.ask("/trust")[0] == 200, "how to trust it")
    answer = server.ask("/api/v1/setup", *page(server), "--json", json.dumps({"code": "1", "user": "eve", "display_name": "Eve", "password": PASSWORD}))
    check(answer[0] == 403 and name_of(answer) == "set-up-closed", f"without switch and code: {answer}")
    for target in ("/api/v1/status", "/api/docs", "/api/openapi.json", "/api/v1/sessions", "/ws", "/foxglove"):
        for more in ([], token):
            answer = server.ask(target, *more)
            check(answer[0] == 403 and name_of(answer) == "set-up-first", f"{target} {more}: {answer}")
    check(server.ask("/api/v1/session", *page(server), "--json", json.dumps({"user": "eve", "password": PASSWORD}))[0] == 403, "nobody signs in yet")
    check(server.ask("/api/v1/stop", "-X", "POST")[0] == 401, "STOP of a stranger")
    check(server.ask("/api/v1/stop", "-X", "POST", *token)[0] == 503, "STOP with a known secret is taken; no core is there")
    check("Set-Cookie" not in str(server.ask(server.link.replace("127.0.0.1", NAME))[1]), "the link is this computer's")
    check(server.ask("/api/v1/status", *token, elsewhere=False)[0] == 200, "from this computer, through its address on the network")


def signed_in(server):
    answer = server.ask("/api/v1/session", *page(server), "--json", json.dumps({"user": "anna", "password": PASSWORD}))
    check(answer[0] == 200 and json.loads(answer[2])["display_name"] == "Anna Weber", f"{answer}")
    cookie = answer[1]["set-cookie"]
    for words in ("__Host-hoist_session=", "Secure", "HttpOnly", "SameSite=Strict", "Path=/"):
        check(words in cookie, cookie)
    return ["-H", "Cookie: " + cookie.partition(";")[0]]


def names_and_origins(server, cookie):
    check(server.ask("/api/v1/status", *cookie)[0] == 200, "signed in by name")
    check(server.ask("/api/v1/status", *cookie, host=HERE)[0] == 200, "and by address, for which the certificate holds, too")
    for host in ("evil.example", TABLET, f"{NAME}.evil.example", "0.0.0.0", "127.0.0.2", f"{HERE}.evil.example"):
        check(server.ask("/api/v1/status", *cookie, "-H", f"Host: {host}:{server.port}")[0] == 421, f"the host {host}")
    for host in (NAME, HERE):
        check(server.ask("/api/v1/ws-ticket", *page(server, host), *cookie, "--json", "{}", host=host)[0] == 200, f"our page at {host}")
    port = server.port
    for origin in ("https://evil.example", f"https://{TABLET}:{port}", f"https://{HERE}:{port}", f"http://{NAME}:{port}", f"https://{NAME}", f"https://{NAME}:{port}.evil.example",
                   "null"):
        answer = server.ask("/api/v1/ws-ticket", "-H", "X-Hoist: 1", "-H", f"Origin: {origin}", *cookie, "--json", "{}")
        check(answer[0] == 403 and name_of(answer) == "foreign-origin", f"a page of {origin} at {NAME}: {answer}")
    ticket = json.loads(server.ask("/api/v1/ws-ticket", *page(server), *cookie, "--json", "{}")[2])["ticket"]
    upgrade = ["--http1.1", "--max-time", "2", "-H", "Connection: Upgrade", "-H", "Upgrade: websocket", "-H", "Sec-WebSocket-Version: 13", "-H",
               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", "-H", "Sec-WebSocket-Protocol: hoist.v1", *cookie]
    for origin, wanted in (("https://evil.example", 403), (f"https://{NAME}:{port}", 101), (f"https://{NAME}:{port}", 403)):
        check(server.ask(f"/ws?ticket={ticket}", *upgrade, "-H", f"Origin: {origin}")[0] == wanted, f"a WebSocket of {origin}: not {wanted}")


def this_computer_keeps_its_own_way(server, token):
    check(server.ask("/api/v1/status", *token)[0] == 401, "the token file is not for other devices")
    check(server.ask("/api/v1/status", *token, elsewhere=False)[0] == 200, "but for this computer")
    check("token=" in server.link and "//127.0.0.1:" in server.link, server.link)
    check(server.ask(server.link, elsewhere=False)[0] == 303, "the link opens here")


def one_address_only():
    begin_anew()
    server = Server("--bind", HERE)
    try:
        trust(server)
        check(f"//{HERE}:" in server.link, server.link)
        check(server.ask("/trust", host=HERE)[0] == 200, "from the tablet")
        check(server.ask(server.link, elsewhere=False)[0] == 303, "the link works on this computer, which calls it by the same address")
    finally:
        server.end()


def main():
    if INSIDE not in os.environ:
        code = enter_own_network()
        if code is not None:
            return code

        def skipped():
            raise Skipped("this machine permits no network namespaces")

        return run_suite("OtherDevices", [skipped])
    try:
        lay_cable()
        return run_suite("OtherDevices", [what_cannot_be_used_is_refused_with_a_sentence, other_devices_set_the_hoist_up_and_sign_in, one_address_only])
    finally:
        if tablet:
            tablet.kill()
            tablet.wait()
        shutil.rmtree(base, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
