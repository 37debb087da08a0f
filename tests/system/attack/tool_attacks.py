"""Attack programs of other people: testssl.sh on the hoist's own certificates, slowhttptest on the console of a walking hoist."""
import http.client
import json
import os
import re
import shutil
import ssl
import subprocess
import time

from ground import Skipped, attack, check
from harness import Program

# What a private authority cannot have (lists of revoked certificates, public logs), and what follows from it: testssl's grade. engine_problem is
# about the openssl of this computer, not about the server.
EXPECTED = re.compile(r"cert_(crlDistributionPoints|revocation|ocspURL|mustStapleExtension|trust)|DNS_CAArecord|OCSP_stapling|HSTS"
                      r"|overall_grade|grade_cap_reason_\d+|engine_problem")
TESTSSL_S = 420


@attack("standby")
def testssl_finds_nothing_but_the_missing_revocation_list(ground):
    program = shutil.which("testssl") or shutil.which("testssl.sh")
    if not program:
        raise Skipped("testssl.sh is not installed")
    folder = ground.hoist.path("own-tls")
    os.makedirs(folder, exist_ok=True)

    def path(name):
        return os.path.join(folder, name)

    server = Program(folder, "hoist-server", os.path.join(ground.hoist.bin, "hoist-server"), "--socket", path("core.sock"), "--port", "0", "--http-port", "0", "--db",
                     path("hoist.db"), "--token-file", path("token"), "--tls-dir", path("tls"), "--host", "hoist.local")
    try:
        server.says("Open https://")
        port = int(re.search(r"Open https://127\.0\.0\.1:(\d+)/", server.output()).group(1))
        line = http.client.HTTPConnection("127.0.0.1", int(re.search(r"http://hoist\.local:(\d+)/", server.output()).group(1)), timeout=30)
        line.request("GET", "/hoist-authority.crt", headers={"Host": "hoist.local"})
        with open(path("ca.pem"), "w") as file:
            file.write(ssl.DER_cert_to_PEM_cert(line.getresponse().read()))
        with open(path("report.json"), "wb"):
            pass
        os.remove(path("report.json"))
        done = subprocess.run(["nice", program, "--quiet", "--color", "0", "--warnings", "off", "--add-ca", path("ca.pem"), "--ip", "127.0.0.1", "--nodns", "none",
                               "--jsonfile", path("report.json"), f"https://hoist.local:{port}"], capture_output=True, text=True, timeout=TESTSSL_S, check=False)
        check(os.path.exists(path("report.json")), done.stdout[-800:] + done.stderr[-800:])
    finally:
        server.end()
    with open(path("report.json")) as file:
        report = json.load(file)
    check(len(report) > 60, f"only {len(report)} findings: it has not looked")
    wrong = [f"{row['id']}: {row['severity']}: {row['finding']}" for row in report
             if row["severity"] not in ("OK", "INFO", "DEBUG") and not EXPECTED.fullmatch(row["id"].partition(" ")[0])]
    check(not wrong, "; ".join(wrong))
    ground.note(f"{len(report)} findings, none wrong but the missing revocation list")


def slow(ground, *options):
    """300 connections, 150 a second, for 15 s. Meanwhile a client that is signed in is answered."""
    if not shutil.which("slowhttptest"):
        raise Skipped("slowhttptest is not installed")
    attacker = subprocess.Popen(["nice", "slowhttptest", "-c", "300", "-r", "150", "-l", "15", "-x", "10", "-p", "2", "-u", f"http://127.0.0.1:{ground.port}/",
                                 *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    longest_s = 0.0
    try:
        while attacker.poll() is None:
            began = time.monotonic()
            check(ground.ask("GET", "/api/v1/status", [ground.bearer]) == 200, "GET /status was refused meanwhile")
            longest_s = max(longest_s, time.monotonic() - began)
            time.sleep(0.25)
        said = attacker.communicate()[0]
    finally:
        if attacker.poll() is None:
            attacker.kill()
            attacker.wait()
    check("slow HTTP test status" in said, said[-800:])
    check(longest_s < 2.0, f"GET /status took {longest_s:.1f} s")
    ground.note(f"longest GET /status {longest_s * 1e3:.0f} ms")


@attack("walking")
def slow_headers_of_slowhttptest(ground):
    slow(ground, "-H", "-i", "2", "-t", "GET")


@attack("walking")
def slow_bodies_of_slowhttptest(ground):
    slow(ground, "-B", "-i", "2", "-s", "8192", "-t", "POST")


@attack("walking")
def slow_reading_of_slowhttptest(ground):
    slow(ground, "-X", "-w", "256", "-y", "512", "-n", "5", "-z", "32", "-k", "3")
