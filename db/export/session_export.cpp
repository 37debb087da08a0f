#include "db/export/session_export.hpp"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "control/contract/check.hpp"
#include "db/export/manifest.hpp"
#include "db/export/source.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"
#include "db/summary/provenance.hpp"

namespace hoist::db {

std::vector<std::string> column_names(std::string_view text) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    names.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return names;
}

namespace {
std::unique_ptr<FormatWriter> writer_of(ExportSource& source) {
  switch (source.options.format) {
#define HOIST_EXPORT(name, ...) \
  case ExportFormat::name:      \
    return make_##name(source);
#include "db/export/formats.def"
#undef HOIST_EXPORT
  }
  return nullptr;
}
// Of everything that the bytes follow from: a stored sample never changes, and the manifest names the rest.
std::string etag_of(const ExportSource& source) {
  std::string text =
      std::string(export_format_info(source.options.format).name) + dumped(manifest_json(source)) + std::to_string(source.last_tick);
  for (const bool option : {source.options.comments, source.options.constant}) text += option ? '1' : '0';
  std::uint64_t hash = contract::hash_bytes(contract::kHashStart, text);
  Moments moments(source);
  while (const auto moment = moments.next()) hash = contract::hash_bytes(hash, dumped(moment_json(*moment)));
  return '"' + layout_text(hash) + '"';
}
}  // namespace

struct SessionExport::State {
  State(Database& database, SessionInfo info, ExportOptions options) : source(database, std::move(info), std::move(options)) {}
  ExportSource source;
  std::string etag;
  std::unique_ptr<FormatWriter> writer;  // nothing when the export is over
};

SessionExport::SessionExport(std::unique_ptr<State> state) : state_(std::move(state)) {}
SessionExport::SessionExport(SessionExport&&) noexcept = default;
SessionExport& SessionExport::operator=(SessionExport&&) noexcept = default;
SessionExport::~SessionExport() = default;

Result<SessionExport> SessionExport::open(Database& database, SessionId session, const ExportOptions& options) {
  return guarded([&]() -> Result<SessionExport> {
    Result<SessionInfo> info = SessionReader(database).get(session);
    if (!info) return info.error();
    Transaction transaction(database.handle(), Transaction::Kind::read);
    auto state = std::make_unique<State>(database, *info, options);
    if (Status chosen = state->source.choose(); !chosen) return chosen.error();
    if (export_format_info(options.format).delivery == ExportDelivery::whole) state->etag = etag_of(state->source);
    state->writer = writer_of(state->source);
    return SessionExport(std::move(state));
  });
}

Result<bool> SessionExport::next_chunk(std::string& out) {
  out.clear();
  Result<bool> more = guarded([&]() -> Result<bool> { return state_->writer && state_->writer->next(out); });
  if (!more) out.clear();
  if (!more || !*more) state_->writer.reset();
  return more;
}

SessionId SessionExport::session() const { return state_->source.info.id; }

std::string SessionExport::etag() const { return state_->etag; }

std::string SessionExport::content_type() const { return std::string(export_format_info(state_->source.options.format).media_type); }

std::string SessionExport::file_name() const {
  const SessionInfo& info = state_->source.info;
  return "hoist_session_" + std::to_string(info.id) + (info.simulated ? "_simulated" : "") +
         std::string(export_format_info(state_->source.options.format).ending);
}

}  // namespace hoist::db
