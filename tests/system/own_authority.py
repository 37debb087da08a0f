"""The hoist's own certificate authority (--tls-dir), judged by programs of other people: openssl, curl, Python's ssl, Chromium. The server alone."""
import http.client
import os
import re
import shutil
import signal
import socket
import ssl
import stat
import subprocess
import sys
import tempfile

from harness import Program, Skipped, check, run, run_suite, until

BIN = sys.argv[1]
NAME, ADDRESS, SUBNET = "hoist.local", "192.168.77.5", "192.168.77.0/24"
folder = tempfile.mkdtemp(prefix="hoist-authority-")
server = None
port = plain_port = 0


def path(*names):
    return os.path.join(folder, *names)


def command(*more):
    return [os.path.join(BIN, "hoist-server"), "--socket", path("core.sock"), "--port", "0", "--db", path("hoist.db"), "--token-file", path("token"),
            "--tls-dir", path("tls"), *more]


def start():
    global server, port, plain_port
    server = Program(folder, "hoist-server", *command("--http-port", "0", "--host", NAME, "--host", ADDRESS, "--subnet", SUBNET))
    server.says("Open https://")
    port = int(re.search(r"Open https://127\.0\.0\.1:(\d+)/", server.output()).group(1))
    plain_port = int(re.search(r"How to trust it: http://[^:]*:(\d+)/", server.output()).group(1))


def plain(target, method="GET", host=None):
    line = http.client.HTTPConnection("127.0.0.1", plain_port, timeout=30)
    line.request(method, target, headers={"Host": host or f"{NAME}:{plain_port}"})
    answer = line.getresponse()
    return answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read()


def secure(target, host=None, headers=None):
    line = http.client.HTTPSConnection("127.0.0.1", port, timeout=30, context=trusting(check_hostname=False))
    line.request("GET", target, headers={"Host": host or f"{NAME}:{port}", **(headers or {})})
    answer = line.getresponse()
    return answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read()


def trusting(check_hostname=True):
    context = ssl.create_default_context(cafile=path("ca.pem"))
    context.check_hostname = check_hostname
    return context


def fetch_authority():
    status, fields, der = plain("/hoist-authority.crt")
    check(status == 200 and fields["content-type"] == "application/x-x509-ca-cert", f"{status} {fields}")
    with open(path("ca.pem"), "w") as file:
        file.write(ssl.DER_cert_to_PEM_cert(der))


def shown(name):
    """The certificate that a new connection for this name gets."""
    done = subprocess.run(["openssl", "s_client", "-connect", f"127.0.0.1:{port}", "-servername", name], input="", capture_output=True, text=True,
                          timeout=60, check=False)
    return re.search(r"-----BEGIN CERTIFICATE-----.*?-----END CERTIFICATE-----\n", done.stdout, re.S).group(0)


def openssl_verifies(certificate, *name, good=True):
    with open(path("shown.pem"), "w") as file:
        file.write(certificate)
    done = subprocess.run(["openssl", "verify", "-x509_strict", "-purpose", "sslserver", "-CAfile", path("ca.pem"), *name, path("shown.pem")],
                          capture_output=True, text=True, timeout=60, check=False)
    check((done.returncode == 0) == good, f"{name}: {done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def openssl_accepts_the_leaf_for_each_of_its_names_and_for_no_other():
    leaf = shown(NAME)
    for name in (NAME, "localhost"):
        openssl_verifies(leaf, "-verify_hostname", name)
    for address in (ADDRESS, "127.0.0.1", "::1"):
        openssl_verifies(leaf, "-verify_ip", address)
    openssl_verifies(leaf, "-verify_hostname", "other.local", good=False)
    text = run("openssl", "x509", "-in", path("shown.pem"), "-noout", "-text")
    for words in ("prime256v1", "CA:FALSE", "TLS Web Server Authentication", "Digital Signature"):
        check(words in text, f"{words} is not in {text}")
    days = run("sh", "-c", f"""expr \\( $(date -d "$(openssl x509 -in {path('shown.pem')} -noout -enddate | cut -d= -f2)" +%s) - \
$(date -d "$(openssl x509 -in {path('shown.pem')} -noout -startdate | cut -d= -f2)" +%s) \\) / 86400""")
    check(int(days) <= 397, f"{days} days")


def the_authority_can_sign_nothing_but_this_hoist():
    text = run("openssl", "x509", "-in", path("ca.pem"), "-noout", "-text")
    for words in ("pathlen:0", "Name Constraints: critical", f"DNS:{NAME}", "IP:192.168.77.0/255.255.255.0", "Certificate Sign"):
        check(words in text, f"{words} is not in {text}")
    # A thief of its key could sign another name, or a further authority: clients must refuse both.
    for file, extensions, words in (("name", "subjectAltName=DNS:bank.example", "permitted subtree violation"),
                                    ("address", "subjectAltName=IP:10.1.2.3", "permitted subtree violation")):
        run("openssl", "req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", "/CN=x", "-keyout", path("x.key"), "-out", path("x.csr"))
        with open(path("x.ext"), "w") as out:
            out.write(f"basicConstraints=critical,CA:FALSE\nextendedKeyUsage=serverAuth\nsubjectKeyIdentifier=hash\nauthorityKeyIdentifier=keyid\n{extensions}\n")
        run("openssl", "x509", "-req", "-in", path("x.csr"), "-CA", path("tls", "authority.pem"), "-CAkey", path("tls", "authority.pem"), "-days", "30", "-extfile",
            path("x.ext"), "-out", path(f"{file}.pem"))
        with open(path(f"{file}.pem")) as made:
            said = openssl_verifies(made.read(), good=False)
        check(words in said, said)


def curl_trusts_it():
    for host in (NAME, ADDRESS):
        done = subprocess.run(["curl", "--silent", "--show-error", "--cacert", path("ca.pem"), "--resolve", f"{host}:{port}:127.0.0.1", "--connect-to",
                               f"{host}:{port}:127.0.0.1:{port}", "-o", "/dev/null", "-w", "%{http_code}", f"https://{host}:{port}/api/docs"],
                              capture_output=True, text=True, timeout=60, check=False)
        check(done.returncode == 0 and done.stdout == "200", f"{host}: {done.stdout} {done.stderr}")
    done = subprocess.run(["curl", "--silent", "--show-error", "--connect-to", f"{NAME}:{port}:127.0.0.1:{port}", f"https://{NAME}:{port}/"],
                          capture_output=True, text=True, timeout=60, check=False)
    check(done.returncode == 60, f"without the authority curl ended with {done.returncode}")


def python_and_chromium_trust_it():
    context = trusting()
    with socket.create_connection(("127.0.0.1", port), 30) as line, context.wrap_socket(line, server_hostname=NAME) as secured:
        check(secured.version() == "TLSv1.3", secured.version())
    chromium = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    if chromium is None:
        raise Skipped("no chromium on this machine")
    openssl_verifies(shown(NAME))
    # Chromium on Linux takes authorities from the user's own NSS database only; the key is named instead, and the page is what is looked at.
    public = run("sh", "-c", f"openssl x509 -in {path('shown.pem')} -pubkey -noout | openssl pkey -pubin -outform der | openssl dgst -sha256 -binary | base64")
    page = subprocess.run([chromium, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={path('chromium')}",
                           f"--host-resolver-rules=MAP {NAME} 127.0.0.1", f"--ignore-certificate-errors-spki-list={public.strip()}", "--dump-dom",
                           f"https://{NAME}:{port}/trust"], capture_output=True, text=True, timeout=120, check=False)
    check("Diesem Gerät vertrauen" in page.stdout, page.stdout[-300:] + page.stderr[-500:])


def the_page_shows_the_fingerprint_and_the_plain_port_serves_nothing_else():
    fingerprint = run("openssl", "x509", "-in", path("ca.pem"), "-noout", "-fingerprint", "-sha256").strip().split("=")[1]
    check(f"SHA-256: {fingerprint}" in server.output(), "the terminal shows it")
    for get in (plain, secure):
        for target in ("/trust",) if get is secure else ("/", "/trust"):
            status, fields, body = get(target)
            check(status == 200 and body.decode().count(fingerprint) == 2, f"{get.__name__} {target}: {status}")
            check(fields["cache-control"] == "no-store" and "frame-ancestors 'none'" in fields["content-security-policy"], f"{fields}")
        check(get("/trust.css")[0] == 200, "its style")
    for target in ("/api/v1/status", "/index.html", "/ws", "/api/openapi.json", "/trust/"):
        status, fields, body = plain(target)
        check(status == 307 and fields["location"] == f"https://{NAME}:{port}/" and body == b"", f"{target}: {status} {fields} {body[:100]}")
    for method in ("POST", "PUT", "DELETE", "OPTIONS"):
        check(plain("/api/v1/stop", method)[0] in (400, 405), method)
    for host in ("evil.example", f"{NAME}.evil.example", f"evil.{NAME}", f"{NAME}.", "192.168.77.6", ""):
        check(plain("/", host=host or " ")[0] in (400, 421), f"plain: {host}")
        check(secure("/api/docs", host=host or " ")[0] in (400, 421), f"HTTPS: {host}")
    for host in (NAME.upper(), f"{ADDRESS}:{port}", "localhost", "[::1]:99"):
        check(secure("/api/docs", host=host)[0] == 200, f"{host} is refused")


def headers_protect_pages_and_data():
    with open(path("token")) as file:
        token = {"Authorization": f"Bearer {file.read().strip()}"}
    for target in ("/trust", "/api/docs", "/api/v1/status", "/nothing"):
        _, fields, _ = secure(target, headers=token)
        for name, value in (("x-content-type-options", "nosniff"), ("cross-origin-opener-policy", "same-origin"), ("referrer-policy", "no-referrer"),
                            ("cross-origin-resource-policy", "same-origin")):
            check(fields.get(name) == value, f"{target}: {name} is {fields.get(name)}")
        for words in ("default-src 'self'", "frame-ancestors 'none'", "base-uri 'none'", "object-src 'none'"):
            check(words in fields["content-security-policy"], f"{target}: {fields['content-security-policy']}")
        # Not on this port: it would hold for every port of the name.
        check("strict-transport-security" not in fields, f"{target}: {fields}")
    check(secure("/api/v1/status", headers=token)[1]["cache-control"] == "no-store", "data are not kept")


def a_new_certificate_is_shown_without_a_restart_and_open_connections_go_on():
    old = shown(NAME)
    line = http.client.HTTPSConnection("127.0.0.1", port, timeout=30, context=trusting(check_hostname=False))
    line.request("GET", "/api/docs", headers={"Host": f"{NAME}:{port}"})
    check(line.getresponse().read() != b"", "before")
    behind = server.said()
    os.remove(path("tls", "server.pem"))
    server.process.send_signal(signal.SIGHUP)
    server.says("a new certificate is in use", behind=behind)
    new = until("new connections get it", lambda: (found := shown(NAME)) != old and found)
    openssl_verifies(new, "-verify_hostname", NAME)
    line.request("GET", "/api/docs", headers={"Host": f"{NAME}:{port}"})
    check(line.getresponse().status == 200, "the open connection goes on")
    # Looked at once more: it is good, so it stays.
    server.process.send_signal(signal.SIGHUP)
    check(plain("/trust")[0] == 200 and shown(NAME) == new, "a good certificate is not replaced")


def keys_are_private_and_a_restart_keeps_the_authority():
    for name in ("authority.pem", "server.pem"):
        check(stat.S_IMODE(os.stat(path("tls", name)).st_mode) == 0o600, name)
    check(stat.S_IMODE(os.stat(path("tls")).st_mode) == 0o700, "the folder")
    before = shown(NAME)
    server.end()
    start()
    check(shown(NAME) == before, "the same certificate after a restart")
    _, _, der = plain("/hoist-authority.crt")
    with open(path("ca.pem")) as file:
        check(ssl.DER_cert_to_PEM_cert(der) == file.read(), "the same authority")


def what_cannot_be_used_is_refused_with_a_sentence():
    refused = [(["--host", "other.local"], "is not among the names"), (["--host", NAME, "--host", "10.9.9.9"], "is not among the names"),
               (["--subnet", "192.168.77.0"], "is not a subnet"), (["--subnet", "10.0.0.0/0"], "is not a subnet"), (["--host", "Hoist_1"], "is not a name"),
               (["--tls-cert", "x", "--tls-key", "y"], "leave --tls-cert"), (["--bind", NAME], "no address")]
    for more, words in refused:
        done = subprocess.run([*command(*more), "--db", path("refused.db")], capture_output=True, text=True, timeout=60, check=False)
        check(done.returncode in (1, 2) and words in done.stderr, f"{more}: {done.returncode} {done.stderr}")
    os.chmod(path("tls", "authority.pem"), 0o640)
    done = subprocess.run([*command("--host", NAME), "--db", path("refused.db")], capture_output=True, text=True, timeout=60, check=False)
    os.chmod(path("tls", "authority.pem"), 0o600)
    check(done.returncode == 1 and "chmod 600" in done.stderr, f"{done.returncode} {done.stderr}")


def main():
    start()
    try:
        fetch_authority()
        return run_suite("OwnAuthority", [
            openssl_accepts_the_leaf_for_each_of_its_names_and_for_no_other,
            the_authority_can_sign_nothing_but_this_hoist,
            curl_trusts_it,
            python_and_chromium_trust_it,
            the_page_shows_the_fingerprint_and_the_plain_port_serves_nothing_else,
            headers_protect_pages_and_data,
            a_new_certificate_is_shown_without_a_restart_and_open_connections_go_on,
            keys_are_private_and_a_restart_keeps_the_authority,
            what_cannot_be_used_is_refused_with_a_sentence,
        ])
    finally:
        server.end()


if __name__ == "__main__":
    sys.exit(main())
