// Events and markers as CSV: '#' lines, names, then one row each. Texts are quoted and cannot start a formula.
#include <array>
#include <optional>

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
    if (!moments_) {
      moments_.emplace(source_);
      if (source_.options.comments) out += manifest_lines(source_);
      out += "utc,time_s,tick,kind,name,code,bits,item,value,before,request_id,user,role,origin,client,text\n";
      return true;
    }
    for (std::size_t line = 0; line < kLinesPerPiece; ++line) {
      const auto moment = moments_->next();
      if (!moment) return line > 0;
      out += (moment->event != nullptr ? line_of(*moment->event) : line_of(*moment->marker)) + "\n";
    }
    return true;
  }

 private:
  static constexpr std::size_t kLinesPerPiece = 256;
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
    return stamp(marker.utc_ns, microseconds_since(source_.start_ns(), source_.time_of_tick(marker.tick))) + ',' +
           std::to_string(marker.tick) + ",marker," + csv_cell(marker.kind) + ",,,,,," + actor_cells(marker.actor) + ',' +
           csv_cell(marker.text);
  }

  ExportSource& source_;
  UtcPrinter utc_;
  std::optional<Moments> moments_;
};

}  // namespace

std::unique_ptr<FormatWriter> make_events(ExportSource& source) { return std::make_unique<EventsWriter>(source); }

}  // namespace hoist::db
