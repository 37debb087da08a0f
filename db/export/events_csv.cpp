// Events and markers as CSV: '#' lines, names, then one row each. Texts are quoted and cannot start a formula.
#include <algorithm>
#include <array>

#include "db/export/fixed_point.hpp"
#include "db/export/manifest.hpp"

namespace hoist::db {
namespace {

std::string actor_cells(const std::optional<Actor>& actor) {
  if (!actor) return ",,,,";
  std::string texts;
  for (const std::string& word : {actor->user, actor->role, actor->origin, actor->client}) texts += ',' + csv_cell(word);
  return texts;
}

class EventsWriter : public FormatWriter {
 public:
  explicit EventsWriter(ExportSource& source) : source_(source) {}

  bool next(std::string& out) override {
    if (std::exchange(written_, true)) return false;
    if (source_.options.comments) out += manifest_lines(source_);
    out += "utc,time_s,tick,kind,name,code,bits,item,value,before,request_id,user,role,origin,client,text\n";
    std::vector<Line> lines;
    for (const StoredEvent& event : source_.events()) lines.push_back({event.tick, line_of(event)});
    for (const Marker& marker : source_.markers()) lines.push_back({marker.tick, line_of(marker)});
    std::ranges::stable_sort(lines, {}, &Line::tick);
    for (const Line& line : lines) out += line.text + "\n";
    return true;
  }

 private:
  struct Line {
    std::uint64_t tick;
    std::string text;
  };
  std::string stamp(std::int64_t utc_ns, std::int64_t micros) {
    std::array<char, 2 * kMaxNumber_chars> text;
    char* at = utc_.print(text.data(), utc_ns);
    *at++ = ',';
    at = print_fixed(at, micros, kSeconds_decimals);
    return {text.data(), at};
  }
  std::string line_of(const StoredEvent& event) {
    const auto time_ns = static_cast<std::int64_t>(event.time_ns);
    std::string line = stamp(source_.utc_of(time_ns), microseconds_since(source_.start_ns(), time_ns));
    line += ',' + std::to_string(event.tick) + ',' + csv_cell(event.kind_name) + ',' + csv_cell(event.name);
    for (const std::uint32_t number : {event.code, event.bits, event.item}) line += ',' + std::to_string(number);
    line += ',' + number_text(event.value, "") + ',' + number_text(event.before, "");
    return line + ',' + std::to_string(event.request_id) + actor_cells(event.actor) + ',';
  }
  std::string line_of(const Marker& marker) {
    return stamp(marker.utc_ns, microseconds_since(source_.info.started_utc_ns, marker.utc_ns)) + ',' + std::to_string(marker.tick) +
           ",marker," + csv_cell(marker.kind) + ",,,,,," + actor_cells(marker.actor) + ',' + csv_cell(marker.text);
  }

  ExportSource& source_;
  UtcPrinter utc_;
  bool written_ = false;
};

}  // namespace

std::unique_ptr<FormatWriter> make_events(ExportSource& source) { return std::make_unique<EventsWriter>(source); }

}  // namespace hoist::db
