// A session for MATLAB and Octave: a level 5 MAT-file, uncompressed, written without libmatio (DECISIONS). One variable per live value and
// `time_s`, `gap_before`; `manifest` and `events` are JSON texts for jsondecode. One stored chunk of one column is in memory.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "control/contract/program_version.hpp"
#include "db/export/manifest.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

using nlohmann::json;
static_assert(std::endian::native == std::endian::little, "the file says so");

// Data types and classes of the format (MathWorks, "MAT-File Format").
enum DataType : std::uint32_t { kInt8 = 1, kUint8 = 2, kUint16 = 4, kInt32 = 5, kUint32 = 6, kDouble = 9, kUint64 = 13, kMatrix = 14 };
enum ArrayClass : std::uint32_t { kChars = 4, kDoubles = 6, kUint8s = 9, kUint16s = 11, kInt32s = 12, kUint32s = 13, kUint64s = 15 };
struct Kind {
  std::string_view type;  // of signals.def
  DataType data;
  ArrayClass array;
  std::size_t size;
};
constexpr std::array kKinds{Kind{"f32", kDouble, kDoubles, 8}, Kind{"u64", kUint64, kUint64s, 8}, Kind{"u32", kUint32, kUint32s, 4},
                            Kind{"i32", kInt32, kInt32s, 4},   Kind{"u16", kUint16, kUint16s, 2}, Kind{"u8", kUint8, kUint8s, 1}};
constexpr Kind kTruth = kKinds.back(), kReal = kKinds.front();
// A variable's length is a signed number of 32 bits.
constexpr std::uint64_t kMaxSamples = (std::uint64_t{1} << 31) / sizeof(double) - 64;

const Kind& kind_of(std::string_view type) {
  const auto at = std::ranges::find(kKinds, type, &Kind::type);
  return at == kKinds.end() ? kKinds.front() : *at;
}

constexpr std::size_t padded(std::size_t bytes) { return (bytes + 7) / 8 * 8; }
void number(std::string& out, std::uint32_t value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); }
void pad(std::string& out, std::size_t bytes) { out.append(padded(bytes) - bytes, '\0'); }

// Everything of a variable but its data and their padding.
void begin_variable(std::string& out, std::string_view name, ArrayClass array, std::uint32_t rows, std::uint32_t columns, DataType data,
                    std::size_t bytes) {
  number(out, kMatrix);
  number(out, static_cast<std::uint32_t>(16 + 16 + 8 + padded(name.size()) + 8 + padded(bytes)));
  for (const std::uint32_t value : {std::uint32_t{kUint32}, 8U, std::uint32_t{array}, 0U}) number(out, value);
  for (const std::uint32_t value : {std::uint32_t{kInt32}, 8U, rows, columns}) number(out, value);
  number(out, kInt8);
  number(out, static_cast<std::uint32_t>(name.size()));
  out += name;
  pad(out, name.size());
  number(out, data);
  number(out, static_cast<std::uint32_t>(bytes));
}

class MatWriter : public FormatWriter {
 public:
  explicit MatWriter(ExportSource& source) : source_(source) {
    if (source.sample_count > kMaxSamples)
      throw SqlFailure{Error{ErrorKind::bad_value, "a MAT-file holds at most " + std::to_string(kMaxSamples) + " samples", "format"}};
  }

  bool next(std::string& out) override {
    if (!head_written_) {
      head_written_ = true;
      head(out);
      return true;
    }
    // time_s, gap_before, then the chosen columns.
    if (column_ < source_.chosen.size() + 2) {
      piece(out);
      return true;
    }
    if (!moments_) {
      text(out, "manifest", dumped_ascii(manifest_json(source_)));
      begin_events(out);
      return true;
    }
    return events(out);
  }

 private:
  // ASCII only, so that a character is a byte.
  static std::string dumped_ascii(const json& value) { return value.dump(-1, ' ', true, json::error_handler_t::replace); }

  void head(std::string& out) {
    std::string words = "MATLAB 5.0 MAT-file, hoist " + std::string(contract::program_version()) + ", session " +
                        std::to_string(source_.info.id) + (source_.info.simulated ? ", simulated" : "");
    words.resize(116, ' ');
    out += words;
    out.append(8, '\0');      // no subsystem data
    out.append("\0\1IM", 4);  // version, byte order
  }

  static void characters(std::string& out, std::string_view ascii) {
    for (const char c : ascii) {
      out += c;
      out += '\0';
    }
  }
  static void text(std::string& out, std::string_view name, const std::string& ascii) {
    begin_variable(out, name, kChars, 1, static_cast<std::uint32_t>(ascii.size()), kUint16, 2 * ascii.size());
    characters(out, ascii);
    pad(out, 2 * ascii.size());
  }

  // [event,event,…]: read twice, since the length stands in front.
  void begin_events(std::string& out) {
    std::uint64_t rows = 0;
    events_size_ = 2;
    Moments all(source_);
    while (const auto moment = all.next()) events_size_ += dumped_ascii(moment_json(*moment)).size() + (rows++ > 0 ? 1 : 0);
    begin_variable(out, "events", kChars, 1, static_cast<std::uint32_t>(events_size_), kUint16, 2 * events_size_);
    characters(out, "[");
    written_ = 1;
    moments_.emplace(source_);
  }
  bool events(std::string& out) {
    if (events_over_) return false;
    constexpr int kEventsPerPiece = 256;
    for (int i = 0; i < kEventsPerPiece; ++i) {
      const auto moment = moments_->next();
      const std::string row = moment ? (written_ > 1 ? "," : "") + dumped_ascii(moment_json(*moment)) : "]";
      characters(out, row);
      written_ += row.size();
      if (moment) continue;
      events_over_ = true;
      if (written_ != events_size_) fail_changed();
      pad(out, 2 * written_);
      break;
    }
    return true;
  }

  void piece(std::string& out) {
    const std::size_t which = column_ == 0 ? source_.time_column : column_ == 1 ? source_.tick_column : source_.chosen[column_ - 2];
    const Kind& kind = column_ == 0 ? kReal : column_ == 1 ? kTruth : kind_of(source_.layout[which].type);
    if (!std::exchange(begun_, true)) {
      const std::string name = column_ == 0 ? "time_s" : column_ == 1 ? "gap_before" : source_.layout[which].name;
      begin_variable(out, name, kind.array, static_cast<std::uint32_t>(source_.sample_count), 1, kind.data,
                     source_.sample_count * kind.size);
      written_ = 0;
    }
    if (!source_.chunk && !source_.next_samples(std::array{which, source_.tick_column})) {
      end_variable(out, kind);
      return;
    }
    const std::vector<std::int64_t>&numbers = source_.values[0], &ticks = source_.values[1];
    for (std::size_t row = 0; row < numbers.size(); ++row) {
      const auto tick = static_cast<std::uint64_t>(ticks[row]);
      if (!source_.wanted(tick)) continue;
      value(out, kind, numbers[row], tick, source_.layout[which].decimals);
      source_.written_tick = tick;
      ++written_;
    }
    source_.chunk.reset();
  }

  void value(std::string& out, const Kind& kind, std::int64_t stored, std::uint64_t tick, int decimals) {
    if (column_ == 1) stored = source_.gap_before(tick) ? 1 : 0;
    double real = static_cast<double>(stored) / decimal_scale(decimals);
    if (column_ == 0) real = static_cast<double>(microseconds_since(source_.start_ns(), stored)) / decimal_scale(kSeconds_decimals);
    const void* const from = kind.data == kDouble ? static_cast<const void*>(&real) : &stored;
    out.append(static_cast<const char*>(from), kind.size);
  }

  // The length stands in front of the data: a session that has lost samples meanwhile cannot be finished.
  void end_variable(std::string& out, const Kind& kind) {
    if (written_ != source_.sample_count) fail_changed();
    pad(out, written_ * kind.size);
    source_.rewind();
    begun_ = false;
    ++column_;
  }

  [[noreturn]] void fail_changed() const {
    throw SqlFailure{Error{ErrorKind::corrupt, "session " + std::to_string(source_.info.id) + " changed during its export", {}}};
  }

  ExportSource& source_;
  std::size_t column_ = 0;
  std::uint64_t written_ = 0, events_size_ = 0;
  std::optional<Moments> moments_;
  bool head_written_ = false, begun_ = false, events_over_ = false;
};

}  // namespace

std::unique_ptr<FormatWriter> make_mat(ExportSource& source) { return std::make_unique<MatWriter>(source); }

}  // namespace hoist::db
