"""Attack tools of other people: testssl.sh on the hoist's own certificates, slowhttptest on the console of a walking hoist."""
import json
import os
import re
import shutil
import ssl
import subprocess
import http.client

from ground import attack
from harness import Program, Skipped, check

# What a private authority cannot have: a list of revoked certificates, and a place in public logs.
EXPECTED = {"cert_crlDistributionPoints", "cert_revocation", "cert_ocspURL", "DNS_CAArecord", "cert_mustStapleExtension", "OCSP_stapling", "overall_grade",
            "grade_cap_reason_1", "HSTS", "cert_trust"}


@attack("walking")
def testssl_complains_about_nothing_but_the_missing_revocation_list(ground):
    if not shutil.which("testssl"):
        raise Skipped("no testssl.sh on this machine")
    folder = ground.hoist.path("own-tls")
    os.makedirs(folder, exist_ok=True)
    path = lambda name: os.path.join(folder, name)  # noqa: E731
    server = Program(folder, "hoist-server", os.path.join(ground.hoist.bin, "hoist-server"), "--socket", path("core.sock"), "--port", "0", "--http-port", "0",
                     "--db", path("hoist.db"), "--token-file", path("token"), "--tls-dir", path("tls"), "--host", "hoist.local")
    try:
        server.says("Open https://")
        port = int(re.search(r"Open https://127\.0\.0\.1:(\d+)/", server.output()).group(1))
        line = http.client.HTTPConnection("127.0.0.1", int(re.search(r"http://hoist\.local:(\d+)/", server.output()).group(1)), timeout=30)
        line.request("GET", "/hoist-authority.crt", headers={"Host": "hoist.local"})
        with open(path("ca.pem"), "w") as file:
            file.write(ssl.DER_cert_to_PEM_cert(line.getresponse().read()))
        subprocess.run(["nice", "testssl", "--quiet", "--color", "0", "--warnings", "off", "--add-ca", path("ca.pem"), "--ip", "127.0.0.1", "--nodns", "none",
                        "--jsonfile", path("report.json"), f"https://hoist.local:{port}"], capture_output=True, timeout=600, check=False)
    finally:
        server.end()
    with open(path("report.json")) as file:
        report = json.load(file)
    check(len(report) > 60, f"only {len(report)} findings: it has not looked")
    wrong = [f"{row['id']}: {row['severity']}: {row['finding']}" for row in report if row["severity"] not in ("OK", "INFO", "DEBUG") and row["id"] not in EXPECTED]
    check(not wrong, "; ".join(wrong))


def slow(ground, *options):
    if not shutil.which("slowhttptest"):
        raise Skipped("no slowhttptest on this machine")
    done = subprocess.run(["nice", "slowhttptest", "-c", "300", "-r", "150", "-l", "15", "-x", "10", "-p", "2", "-u", f"http://127.0.0.1:{ground.port}/", *options],
                          capture_output=True, text=True, timeout=120, check=False)
    check("slow HTTP test status" in done.stdout, done.stdout[-500:] + done.stderr[-500:])
    status, _, _ = ground.ask("GET", "/api/v1/status", [ground.bearer])[:3]
    check(status == 200, f"a signed-in client gets {status}")


@attack("walking")
def slow_headers_of_slowhttptest_keep_nobody_out(ground):
    slow(ground, "-H", "-i", "2", "-t", "GET")


@attack("walking")
def slow_bodies_of_slowhttptest_keep_nobody_out(ground):
    slow(ground, "-B", "-i", "2", "-s", "8192", "-t", "POST")


@attack("walking")
def slow_reading_of_slowhttptest_keeps_nobody_out(ground):
    slow(ground, "-X", "-w", "256", "-y", "512", "-n", "5", "-z", "32", "-k", "3")
