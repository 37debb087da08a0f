// The rows of a bench: value, reference and goal; printed, stored, and compared with an earlier run.
#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace hoist::bench {

enum class Better : unsigned char { lower, higher };

// Goal of a row: for its ratio where it has a floor, else for its value.
struct Goal {
  double limit = 0;  // 0: none
  Better better = Better::lower;
};

struct Row {
  std::string id;  // "section.name": key of stored files, never reused for another figure
  std::string what;
  double value = 0;
  std::string unit;
  double floor = 0;  // 0: none
  std::string floor_what;
  Goal goal = {};
  bool exact = false;  // a count or size that does not depend on the machine's load: compared without a floor
  std::string note = {};
  std::string skipped = {};  // why it was not measured
  bool busy = false;         // other programs used the machine meanwhile; set by run()
};

[[nodiscard]] double figure(const Row& row);  // the ratio to the floor, or the value
[[nodiscard]] bool comparable(const Row& row);
[[nodiscard]] bool judged(const Row& row);  // comparable, and no time of a busy machine
[[nodiscard]] bool met(const Row& row);     // only for a row with a goal
[[nodiscard]] std::string line_of(const Row& row);

struct Stored {
  double figure = 0;
  Better better = Better::lower;
};
using StoredFigures = std::map<std::string, Stored>;

// Throws std::runtime_error with the line's number when a line is not "ID FIGURE lower|higher". '#' begins a comment.
[[nodiscard]] StoredFigures parse_stored(const std::string& text);
[[nodiscard]] std::string print_stored(const StoredFigures& stored);
// Puts the judged rows over what is stored; figures of sections that did not run stay.
void store_rows(StoredFigures& stored, const std::vector<Row>& rows);

inline constexpr double kWorseAllowed = 0.10;

struct Comparison {
  std::vector<std::string> failures;  // one sentence each
  std::vector<std::string> remarks;   // rows that were skipped, have no stored figure, or are times of a busy machine
};
// `sections`: what ran. A stored figure of such a section must have been measured; a row skipped with a reason is a remark.
[[nodiscard]] Comparison compare(const StoredFigures& stored, const std::vector<Row>& rows, const std::vector<std::string>& sections);

// Takes the rows of one section. What was added before a section throws is kept.
class Report {
 public:
  std::function<void(const Row&)> on_row;
  std::function<void(const std::string&)> on_progress;
  void add(Row row);
  // Marks the rows from this one on.
  void mark_busy(std::size_t from);
  void skip(const std::string& id, const std::string& what, const std::string& reason);
  void progress(const std::string& text) const;
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }

 private:
  std::vector<Row> rows_;
};

struct Section {
  std::string name;
  std::string what;
  std::function<void(Report&)> measure;
};
// Share of the processors' time that programs use while this one waits for half a second; above kBusyFrom times are printed and not judged.
inline constexpr double kBusyFrom = 0.10;
[[nodiscard]] double used_by_others();

struct Options {
  std::vector<std::string> only;
  std::string store, compare;
  bool help = false;
  std::function<double()> used_by_others = bench::used_by_others;  // asked before and after each section
};
// Throws std::runtime_error with a sentence.
[[nodiscard]] Options parse_options(const std::vector<std::string>& arguments, const std::vector<Section>& sections);
// 0: measured and not worse; 1: a section failed, or a judged figure is more than kWorseAllowed worse than stored. Missed goals do not count.
// Rows go to stdout, progress to stderr. Throws when a file cannot be read or written.
[[nodiscard]] int run(const std::vector<Section>& sections, const Options& options);

}  // namespace hoist::bench
