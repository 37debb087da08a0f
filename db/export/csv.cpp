// All samples as CSV. Numbers are the stored integers, printed with their decimal point: no floating point takes part.
//
// Lines starting with '#' (manifest.hpp; the last two say each column's direction and unit), one row of column names, one row per sample:
// utc, time_s, gap_before, then the columns. gap_before is 1 when samples are missing before the row. Every line is a record of RFC 4180.
#include <algorithm>
#include <array>
#include <cstring>

#include "control/contract/axes.hpp"
#include "db/export/fixed_point.hpp"
#include "db/export/manifest.hpp"

namespace hoist::db {
namespace {

constexpr std::size_t kCsvRowsPerPiece = 256;

struct Dialect {
  char separator, decimal_point;
  std::string_view begin;  // a byte order mark
};
constexpr Dialect kPlain{',', '.', ""}, kGerman{';', ',', "\xEF\xBB\xBF"};

class CsvWriter : public FormatWriter {
 public:
  CsvWriter(ExportSource& source, const Dialect& dialect) : source_(source), dialect_(dialect), cells_(source.chosen.size()) {
    which_ = source.chosen;
    which_.push_back(source.tick_column);
    which_.push_back(source.time_column);
  }

  bool next(std::string& out) override {
    if (head_written_) return rows(out);
    head_written_ = true;
    head(out);
    return true;
  }

 private:
  struct Cell {
    std::int64_t value = 0;
    std::size_t length = 0;  // 0 = nothing printed yet
    std::array<char, 32> text{};
  };

  // What each column is, under its place in the row of names.
  void column_line(std::string& out, std::initializer_list<std::string_view> first, auto text_of) {
    bool begun = false;
    for (const std::string_view text : first) {
      if (std::exchange(begun, true)) out += dialect_.separator;
      out += text;
    }
    for (const std::size_t c : source_.chosen) {
      out += dialect_.separator;
      out += csv_cell(text_of(source_.layout[c]), dialect_.separator);
    }
    out += '\n';
  }

  void head(std::string& out) {
    out += dialect_.begin;
    if (source_.options.comments) {
      out += manifest_lines(source_, dialect_.separator);
      column_line(out, {"# axes:", "", ""}, [](const ColumnInfo& column) { return contract::axis_of(column.name); });
      column_line(out, {"# units: UTC", "s", ""}, [](const ColumnInfo& column) { return std::string_view(column.unit); });
    }
    column_line(out, {"utc", "time_s", "gap_before"}, [](const ColumnInfo& column) { return std::string_view(column.name); });
  }

  char* number(char* at, std::int64_t value, int decimals) const {
    char* const end = print_fixed(at, value, decimals);
    if (decimals != 0) end[-decimals - 1] = dialect_.decimal_point;
    return end;
  }

  bool rows(std::string& out) {
    if (!source_.chunk && !source_.next_samples(which_)) return false;
    const std::size_t columns = source_.chosen.size();
    const std::vector<std::int64_t>& ticks = source_.values[columns];
    const std::vector<std::int64_t>& times = source_.values[columns + 1];
    const std::size_t end = std::min(source_.row + kCsvRowsPerPiece, ticks.size()), before = out.size();
    out.resize(before + (end - source_.row) * (columns + 3) * kMaxNumber_chars);
    char* at = out.data() + before;
    for (; source_.row < end; ++source_.row) {
      const std::size_t row = source_.row;
      const auto tick = static_cast<std::uint64_t>(ticks[row]);
      if (!source_.wanted(tick)) continue;
      at = utc_.print(at, source_.utc_of(times[row]));
      *at++ = dialect_.separator;
      at = number(at, microseconds_since(source_.start_ns(), times[row]), kSeconds_decimals);
      *at++ = dialect_.separator;
      *at++ = source_.gap_before(tick) ? '1' : '0';
      for (std::size_t c = 0; c < columns; ++c) at = cell(at, c, source_.values[c][row]);
      *at++ = '\n';
      source_.written_tick = tick;
    }
    out.resize(static_cast<std::size_t>(at - out.data()));
    if (source_.row >= ticks.size()) source_.chunk.reset();
    return true;
  }

  // Half of the columns rarely change: their text is copied instead of printed again.
  char* cell(char* at, std::size_t column, std::int64_t value) {
    Cell& cell = cells_[column];
    if (value != cell.value || cell.length == 0) {
      cell.text[0] = dialect_.separator;
      cell.length =
          static_cast<std::size_t>(number(cell.text.data() + 1, value, source_.layout[source_.chosen[column]].decimals) - cell.text.data());
      cell.value = value;
    }
    std::memcpy(at, cell.text.data(), cell.text.size());
    return at + cell.length;
  }

  ExportSource& source_;
  const Dialect& dialect_;
  std::vector<std::size_t> which_;  // chosen columns, then tick and time
  std::vector<Cell> cells_;
  UtcPrinter utc_;
  bool head_written_ = false;
};

}  // namespace

std::unique_ptr<FormatWriter> make_csv(ExportSource& source) { return std::make_unique<CsvWriter>(source, kPlain); }
std::unique_ptr<FormatWriter> make_csv_de(ExportSource& source) { return std::make_unique<CsvWriter>(source, kGerman); }

}  // namespace hoist::db
