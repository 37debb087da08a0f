#include "tests/bench/table.hpp"

#include <poll.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace hoist::bench {
namespace {
std::string formatted(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}
const char* name_of(Better better) { return better == Better::lower ? "lower" : "higher"; }
std::string section_of(const std::string& id) { return id.substr(0, id.find('.')); }

std::string read_whole(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}
bool has(const std::vector<std::string>& list, const std::string& word) { return std::find(list.begin(), list.end(), word) != list.end(); }
}  // namespace

double figure(const Row& row) { return row.floor > 0 ? row.value / row.floor : row.value; }
bool comparable(const Row& row) { return row.skipped.empty() && (row.floor > 0 || row.exact) && std::isfinite(figure(row)); }
bool judged(const Row& row) { return comparable(row) && (row.exact || !row.busy); }
bool met(const Row& row) { return row.goal.better == Better::lower ? figure(row) <= row.goal.limit : figure(row) >= row.goal.limit; }

std::string line_of(const Row& row) {
  char head[160];
  if (!row.skipped.empty()) {
    std::snprintf(head, sizeof head, "%-26s %-56s ", row.id.c_str(), row.what.c_str());
    return head + ("skipped: " + row.skipped);
  }
  std::snprintf(head, sizeof head, "%-26s %-56s %9.5g %-6s", row.id.c_str(), row.what.c_str(), row.value, row.unit.c_str());
  std::string line = head;
  if (row.floor > 0) line += " " + formatted("%.3g", figure(row)) + " x " + row.floor_what + " (" + formatted("%.4g", row.floor) + ")";
  if (row.goal.limit > 0)
    line += std::string("  goal ") + (row.goal.better == Better::lower ? "<= " : ">= ") + formatted("%.5g", row.goal.limit) +
            (met(row) ? ": met" : ": NOT MET");
  if (!row.note.empty()) line += "  [" + row.note + "]";
  return line;
}

StoredFigures parse_stored(const std::string& text) {
  StoredFigures stored;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    line = line.substr(0, line.find('#'));
    std::istringstream words(line);
    std::string id, better, more;
    Stored figure;
    if (!(words >> id)) continue;
    const bool whole = (words >> figure.figure >> better) && !(words >> more);
    if (!whole || (better != "lower" && better != "higher") || !(figure.figure > 0))
      throw std::runtime_error("line " + std::to_string(number) + " is not \"ID FIGURE lower|higher\": " + line);
    figure.better = better == "lower" ? Better::lower : Better::higher;
    if (!stored.emplace(id, figure).second) throw std::runtime_error("line " + std::to_string(number) + " repeats " + id);
  }
  return stored;
}
std::string print_stored(const StoredFigures& stored) {
  std::string text = "# Written by hoist-bench --store: ratios to the floor, or exact counts. ID FIGURE better\n";
  for (const auto& [id, figure] : stored) text += id + " " + formatted("%.6g", figure.figure) + " " + name_of(figure.better) + "\n";
  return text;
}
void store_rows(StoredFigures& stored, const std::vector<Row>& rows) {
  for (const Row& row : rows)
    if (judged(row) && figure(row) > 0) stored[row.id] = {figure(row), row.goal.better};
}

Comparison compare(const StoredFigures& stored, const std::vector<Row>& rows, const std::vector<std::string>& sections) {
  Comparison result;
  for (const Row& row : rows)
    if (comparable(row) && !stored.contains(row.id)) result.remarks.push_back(row.id + " has no stored figure");
  for (const auto& [id, before] : stored) {
    if (!has(sections, section_of(id))) continue;
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.id == id; });
    if (row == rows.end()) {
      result.failures.push_back(id + " is stored and was not measured");
    } else if (!row->skipped.empty()) {
      result.remarks.push_back(id + " was skipped: " + row->skipped);
    } else if (comparable(*row) && !judged(*row)) {
      result.remarks.push_back(id + " is not judged: other programs used the machine");
    } else {
      const double now = figure(*row);
      const double worse = before.better == Better::lower ? now / before.figure - 1 : before.figure / now - 1;
      if (!(worse <= kWorseAllowed))
        result.failures.push_back(id + " is " + formatted("%.0f", worse * 100) + " % worse: " + formatted("%.4g", now) + ", stored " +
                                  formatted("%.4g", before.figure));
    }
  }
  return result;
}

void Report::add(Row row) {
  rows_.push_back(std::move(row));
  if (on_row) on_row(rows_.back());
}
void Report::mark_busy(std::size_t from) {
  for (std::size_t i = from; i < rows_.size(); ++i) rows_[i].busy = true;
}
void Report::skip(const std::string& id, const std::string& what, const std::string& reason) {
  Row row;
  row.id = id;
  row.what = what;
  row.skipped = reason;
  add(std::move(row));
}
void Report::progress(const std::string& text) const {
  if (on_progress) on_progress(text);
}

Options parse_options(const std::vector<std::string>& arguments, const std::vector<Section>& sections) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (word == "--help" || word == "-h") {
      options.help = true;
      continue;
    }
    if (word != "--only" && word != "--store" && word != "--compare")
      throw std::runtime_error("unknown argument " + word + "; --help lists them");
    if (++i == arguments.size()) throw std::runtime_error(word + " needs a value");
    const std::string& value = arguments[i];
    if (word == "--store") options.store = value;
    if (word == "--compare") options.compare = value;
    if (word != "--only") continue;
    if (std::none_of(sections.begin(), sections.end(), [&](const Section& s) { return s.name == value; }))
      throw std::runtime_error("there is no section \"" + value + "\"; --help lists them");
    options.only.push_back(value);
  }
  return options;
}

namespace {
void print_summary(const std::vector<Row>& rows, std::size_t failed_sections) {
  std::size_t reached = 0, missed = 0, skipped = 0;
  for (const Row& row : rows) {
    if (!row.skipped.empty())
      ++skipped;
    else if (row.goal.limit > 0)
      ++(met(row) ? reached : missed);
  }
  std::printf("%zu rows: %zu goals met, %zu not met, %zu rows skipped, %zu sections failed\n", rows.size(), reached, missed, skipped,
              failed_sections);
}
bool print_comparison(const Comparison& comparison) {
  for (const std::string& remark : comparison.remarks) std::printf("remark: %s\n", remark.c_str());
  for (const std::string& failure : comparison.failures) std::printf("WORSE: %s\n", failure.c_str());
  if (comparison.failures.empty()) std::printf("nothing is more than %.0f %% worse than stored\n", kWorseAllowed * 100);
  return comparison.failures.empty();
}
void write_stored(const std::string& path, const std::vector<Row>& rows) {
  StoredFigures stored;
  if (std::ifstream(path)) stored = parse_stored(read_whole(path));
  store_rows(stored, rows);
  std::ofstream file(path);
  file << print_stored(stored);
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}
}  // namespace

double used_by_others() {
  struct Ticks {
    double all = 0, idle = 0;
  };
  const auto look = [] {
    std::ifstream file("/proc/stat");
    std::string cpu;
    file >> cpu;
    Ticks ticks;
    // user nice system idle iowait irq softirq steal; what a host takes away is used, too.
    for (int field = 0; field < 8; ++field) {
      double value = 0;
      file >> value;
      ticks.all += value;
      if (field == 3 || field == 4) ticks.idle += value;
    }
    return ticks;
  };
  const Ticks before = look();
  ::poll(nullptr, 0, 500);
  const Ticks after = look();
  return after.all > before.all ? 1 - (after.idle - before.idle) / (after.all - before.all) : 0;
}

int run(const std::vector<Section>& sections, const Options& options) {
  StoredFigures before;
  if (!options.compare.empty()) before = parse_stored(read_whole(options.compare));
  Report report;
  report.on_row = [](const Row& row) {
    std::printf("%s\n", line_of(row).c_str());
    std::fflush(stdout);
  };
  std::vector<std::string> ran;
  std::size_t failed = 0;
  for (const Section& section : sections) {
    if (!options.only.empty() && !has(options.only, section.name)) continue;
    ran.push_back(section.name);
    report.on_progress = [&](const std::string& text) { std::fprintf(stderr, "[%s] %s\n", section.name.c_str(), text.c_str()); };
    report.progress(section.what);
    const std::size_t first = report.rows().size();
    const double used_before = options.used_by_others();
    try {
      section.measure(report);
    } catch (const std::exception& problem) {
      std::printf("%-26s FAILED: %s\n", section.name.c_str(), problem.what());
      std::fflush(stdout);
      ++failed;
    }
    if (const double used = std::max(used_before, options.used_by_others()); used > kBusyFrom) {
      std::printf("%-26s other programs used %.0f %% of the machine: its times are not judged\n", section.name.c_str(), used * 100);
      report.mark_busy(first);
    }
  }
  print_summary(report.rows(), failed);
  if (!options.store.empty()) write_stored(options.store, report.rows());
  const bool good = options.compare.empty() || print_comparison(compare(before, report.rows(), ran));
  return failed == 0 && good ? 0 : 1;
}

}  // namespace hoist::bench
