// A session as one JSON object: {"session", "directions", "columns": [{"name", "unit", "lsb", "axis"}], "rows": n, "data": {"time_s": […], …},
// "metrics", "gaps", "events", "markers", "parameters", "manifest"}. One column after the other, so that one chunk's column is in memory.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "db/export/fixed_point.hpp"
#include "db/export/manifest.hpp"
#include "db/store/exercise_json.hpp"
#include "db/summary/provenance.hpp"
#include "db/summary/session_json.hpp"

namespace hoist::db {
namespace {

using nlohmann::json;

constexpr std::size_t kNumbersPerPiece = 8192;

class JsonExport : public FormatWriter {
 public:
  explicit JsonExport(ExportSource& source) : source_(source) {}

  bool next(std::string& out) override {
    switch (step_) {
      case Step::head:
        step_ = Step::body;
        head(out);
        return true;
      case Step::body:
        if (body(out)) return true;
        step_ = Step::figures;
        [[fallthrough]];
      case Step::figures:
        if (source_.figures_piece()) return true;
        step_ = Step::events;
        figures(out);
        return true;
      case Step::events:
        if (events(out)) return true;
        step_ = Step::over;
        tail(out);
        return true;
      case Step::over:
        break;
    }
    return false;
  }

 private:
  enum class Step : std::uint8_t { head, body, figures, events, over };

  void head(std::string& out) {
    manifest_ = manifest_json(source_);
    json session = manifest_["session"];
    session["software_version"] = source_.info.software_version;
    session["core_version"] = source_.info.core_version ? json(*source_.info.core_version) : json(nullptr);
    for (const char* name : {"layout_hash", "nodes"}) session[name] = manifest_[name];
    json columns = json::array();
    columns.push_back({{"name", "time_s"}, {"unit", "s"}, {"lsb", 1e-6}, {"axis", nullptr}});
    columns.push_back({{"name", "gap_before"}, {"unit", ""}, {"lsb", 1.0}, {"axis", nullptr}});
    for (const json& column : manifest_["columns"]) columns.push_back(column);
    out += "{\"session\":" + dumped(session) + ",\n\"directions\":" + dumped(manifest_["directions"]) +
           ",\n\"columns\":" + dumped(columns) + ",\n\"rows\":" + std::to_string(source_.sample_count) + ",\n\"data\":{";
  }

  // time_s, gap_before, then the chosen columns.
  bool body(std::string& out) {
    if (column_ == source_.chosen.size() + 2) return false;
    const std::size_t which = column_ == 0 ? source_.time_column : column_ == 1 ? source_.tick_column : source_.chosen[column_ - 2];
    if (!name_written_) {
      const std::string name = column_ == 0 ? "time_s" : column_ == 1 ? "gap_before" : source_.layout[which].name;
      out += column_ == 0 ? "\n" : ",\n";
      out += dumped(name) + ":[";
      name_written_ = true;
    }
    if (!source_.chunk && !source_.next_samples(std::array{which, source_.tick_column})) {
      out += ']';
      ++column_;
      source_.rewind();
      first_number_ = true;
      name_written_ = false;
      return true;
    }
    numbers(out, which);
    return true;
  }

  void numbers(std::string& out, std::size_t which) {
    const std::vector<std::int64_t>&numbers = source_.values[0], &ticks = source_.values[1];
    const std::size_t end = std::min(source_.row + kNumbersPerPiece, numbers.size()), before = out.size();
    out.resize(before + (end - source_.row) * kMaxNumber_chars);
    char* at = out.data() + before;
    for (; source_.row < end; ++source_.row) {
      const auto tick = static_cast<std::uint64_t>(ticks[source_.row]);
      if (!source_.wanted(tick)) continue;
      if (!std::exchange(first_number_, false)) *at++ = ',';
      if (column_ == 0)
        at = print_fixed(at, microseconds_since(source_.start_ns(), numbers[source_.row]), kSeconds_decimals);
      else if (column_ == 1)
        *at++ = source_.gap_before(tick) ? '1' : '0';
      else
        at = print_fixed(at, numbers[source_.row], source_.layout[which].decimals);
      source_.written_tick = tick;
    }
    out.resize(static_cast<std::size_t>(at - out.data()));
    if (source_.row >= numbers.size()) source_.chunk.reset();
  }

  static json row_of(const StoredEvent& event) {
    return {{"tick", event.tick},
            {"time_ns", event.time_ns},
            {"kind", event.kind_name},
            {"name", event.name},
            {"code", event.code},
            {"bits", event.bits},
            {"item", event.item},
            {"value", finite(event.value)},
            {"before", finite(event.before)},
            {"request_id", event.request_id},
            {"actor", actor_json(event.actor)}};
  }

  void figures(std::string& out) {
    out += "},\n\"metrics\":" + dumped(source_.figures) + ",\n\"gaps\":" + dumped(manifest_["gaps"]) + ",\n\"events\":[";
  }

  // A few at a time; false at the end.
  bool events(std::string& out) {
    const std::vector<StoredEvent> some = source_.events_after(last_event_.value_or(-1));
    for (const StoredEvent& event : some) {
      out += (last_event_ ? "," : "") + dumped(row_of(event));
      last_event_ = event.number;
    }
    return !some.empty();
  }

  void tail(std::string& out) {
    json marker_rows = json::array();
    for (const Marker& marker : source_.markers())
      marker_rows.push_back({{"tick", marker.tick},
                             {"utc_ns", marker.utc_ns},
                             {"kind", marker.kind},
                             {"text", marker.text},
                             {"actor", actor_json(marker.actor)}});
    json parameter_rows = json::object();
    for (const auto& [name, parameter] : manifest_["parameters"].items()) parameter_rows[name] = parameter["value"];
    out += "],\n\"markers\":" + dumped(marker_rows) + ",\n\"parameters\":" + dumped(parameter_rows) +
           ",\n\"manifest\":" + dumped(manifest_) + "}\n";
  }

  ExportSource& source_;
  json manifest_;
  Step step_ = Step::head;
  std::size_t column_ = 0;
  bool first_number_ = true, name_written_ = false;
  std::optional<std::int64_t> last_event_;
};

}  // namespace

std::unique_ptr<FormatWriter> make_json(ExportSource& source) { return std::make_unique<JsonExport>(source); }

}  // namespace hoist::db
