#include "server/api/trust.hpp"

#include "server/http/problem.hpp"

namespace hoist::server {

namespace {
constexpr std::string_view kStyle =
    R"css(body{margin:0 auto;max-width:44rem;padding:1.5rem;font:1.0625rem/1.5 system-ui,sans-serif;color:#1a2530;background:#fff}
h1{font-size:1.5rem}h2{font-size:1.125rem;margin-bottom:.25rem}section+section{margin-top:3rem;border-top:1px solid #ccd4dc}
code{display:block;padding:.75rem;background:#eef2f6;border-radius:.5rem;font-size:1.0625rem;overflow-wrap:anywhere}
a.button{display:inline-block;margin:.25rem .5rem .25rem 0;padding:.75rem 1.25rem;border-radius:.5rem;background:#0b5cad;
color:#fff;text-decoration:none}

@media(prefers-color-scheme:dark){body{color:#e6ebf0;background:#12181f}code{background:#1f2933}section+section{border-color:#3a4653}a{color:#7db8f0}}
)css";

// {name}, {fingerprint} and {console} are filled in.
constexpr std::string_view kPage = R"html(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1"><title>Hoist:
trust this device</title>
<link rel="stylesheet" href="/trust.css"></head><body>
<section>
<h1>Trust this hoist</h1>
<p>The console is encrypted with a certificate that this hoist has made itself. Install it once on each tablet or computer; then
the browser shows no warning and nobody can pose as the hoist.</p>
<h2>1. Compare</h2>
<p>The hoist shows this fingerprint (SHA-256) when it starts, and it stands on its label. If they differ, stop and call service:
you may be connected to another device.</p>
<code>{fingerprint}</code>
<h2>2. Install</h2>
<p><a class="button" href="/hoist-authority.crt" download="hoist-authority.crt">Certificate</a></p>
<ul>
<li><b>iPad, iPhone:</b> open it in Safari and allow the profile. Settings &rsaquo; General &rsaquo; VPN &amp; Device Management:
install. Then Settings &rsaquo; General &rsaquo; About &rsaquo; Certificate Trust Settings: switch it on.</li>
<li><b>Android:</b> Settings, search for &ldquo;CA certificate&rdquo;, choose &ldquo;Install anyway&rdquo; and the downloaded file.</li>
<li><b>Windows:</b> open the file, Install Certificate, Local Machine, store &ldquo;Trusted Root Certification Authorities&rdquo;.</li>
<li><b>macOS:</b> open the file, add it to the keychain System, set &ldquo;When using this certificate&rdquo; to &ldquo;Always
Trust&rdquo;.</li>
<li><b>Firefox</b> on Linux: Settings &rsaquo; Certificates &rsaquo; View Certificates &rsaquo; Authorities &rsaquo; Import, for
websites.</li>
</ul>
<p>It can vouch for this hoist only ({name} and its addresses), for no other website.</p>
<h2>3. Open the console</h2>
<p><a class="button" href="{console}">{name}</a></p>
</section>
<section lang="de">
<h1>Diesem Gerät vertrauen</h1>
<p>Die Konsole ist mit einem Zertifikat verschlüsselt, das dieses Gerät selbst erstellt hat. Auf jedem Tablet oder Rechner einmal
installieren: Danach warnt der Browser nicht mehr, und niemand kann sich als dieses Gerät ausgeben.</p>
<h2>1. Vergleichen</h2>
<p>Das Gerät zeigt diesen Fingerabdruck (SHA-256) beim Start; er steht auch auf dem Typenschild. Weicht er ab: abbrechen und den
Service rufen, Sie könnten mit einem fremden Gerät verbunden sein.</p>
<code>{fingerprint}</code>
<h2>2. Installieren</h2>
<p><a class="button" href="/hoist-authority.crt" download="hoist-authority.crt">Zertifikat</a></p>
<ul>
<li><b>iPad, iPhone:</b> in Safari öffnen und das Profil erlauben. Einstellungen &rsaquo; Allgemein &rsaquo; VPN und
Geräteverwaltung: installieren. Dann Einstellungen &rsaquo; Allgemein &rsaquo; Info &rsaquo; Zertifikatsvertrauenseinstellungen:
einschalten.</li>
<li><b>Android:</b> in den Einstellungen nach &bdquo;CA-Zertifikat&ldquo; suchen, &bdquo;Trotzdem installieren&ldquo; und die
geladene Datei wählen.</li>
<li><b>Windows:</b> Datei öffnen, Zertifikat installieren, Lokaler Computer, Speicher &bdquo;Vertrauenswürdige
Stammzertifizierungsstellen&ldquo;.</li>
<li><b>macOS:</b> Datei öffnen, im Schlüsselbund System ablegen, bei Vertrauen &bdquo;Immer vertrauen&ldquo; wählen.</li>
<li><b>Firefox</b> unter Linux: Einstellungen &rsaquo; Zertifikate &rsaquo; Zertifikate anzeigen &rsaquo; Zertifizierungsstellen
&rsaquo; Importieren, für Websites.</li>
</ul>
<p>Es gilt nur für dieses Gerät ({name} und seine Adressen), für keine andere Website.</p>
<h2>3. Konsole öffnen</h2>
<p><a class="button" href="{console}">{name}</a></p>
</section>
</body></html>
)html";

std::string filled(std::string_view text, std::initializer_list<std::pair<std::string_view, std::string_view>> values) {
  std::string out{text};
  for (const auto& [place, value] : values)
    for (std::size_t at = out.find(place); at != std::string::npos; at = out.find(place, at + value.size()))
      out.replace(at, place.size(), value);
  return out;
}

std::string address_of(std::string_view host, std::uint16_t port) {
  return "https://" + std::string{host} + (port == 443 ? "" : ":" + std::to_string(port)) + "/";
}

// Without its port.
std::string_view host_only(std::string_view host) { return host.substr(0, host.starts_with('[') ? host.find(']') + 1 : host.find(':')); }

Response with(std::string type, std::string body) {
  Response response;
  response.content_type = std::move(type);
  response.body = std::move(body);
  response.set("Cache-Control", "no-store");
  return response;
}
}  // namespace

std::optional<Response> trust_answer(const TrustPage& page, const std::string& path) {
  if (path == "/trust")
    return with(
        "text/html; charset=utf-8",
        filled(kPage, {{"{name}", page.name}, {"{fingerprint}", page.fingerprint}, {"{console}", address_of(page.name, page.port)}}));
  if (path == "/trust.css") return with("text/css; charset=utf-8", std::string{kStyle});
  if (path == "/hoist-authority.crt") return with("application/x-x509-ca-cert", page.certificate);
  return std::nullopt;
}

Response PlainDoor::answer_to(const Request& request) const {
  if (!auth_.host_allowed(request.header("host"))) {
    counters_.add(Count::http_refused_host);
    return problem_response({.status = 421,
                             .name = "host",
                             .title = "This name does not belong to the hoist",
                             .detail = "Open the address that stands on the hoist."},
                            request.path);
  }
  if (request.method != Method::get && request.method != Method::head) {
    counters_.add(Count::http_refused_method);
    Response response = problem_response(
        {.status = 405, .name = "method", .title = "This cannot be done here", .detail = "This port only leads to HTTPS."}, request.path);
    response.set("Allow", "GET, HEAD");
    return response;
  }
  if (auto answer = trust_answer(page_, request.path == "/" ? "/trust" : request.path)) return std::move(*answer);
  Response response = with("", "");
  response.status = 307;
  response.set("Location", address_of(host_only(request.header("host")), page_.port));
  return response;
}

void PlainDoor::handle(Request request, std::function<void(Response)> answer) {
  counters_.add(Count::http_requests);
  Response response = answer_to(request);
  if (response.status >= 400) counters_.add(Count::http_refused);
  answer(std::move(response));
}

}  // namespace hoist::server
