// What a study tells, computed once: as text for the command line (tables.hpp) and as JSON for the console.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "db/metrics/paired_test.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"
#include "deploy/tools/hoist/study/results.hpp"

namespace hoist::tool::study {

/// One of the paper's tables. `own` and `paper` are indexed by run (in the protocol's order) and row; all columns are as long as `subjects`.
struct Table {
  std::string_view figure, title;
  int decimals = 2;
  std::vector<std::string> subjects = {};  ///< codes; "-" where only the paper has a row
  std::vector<Column> own = {}, paper = {};
  Column own_mean = {}, paper_mean = {};  ///< by run, over the subjects present
};

/// One figure in two runs, by the subjects who did both.
struct Comparison {
  std::string_view figure;
  int from = 0, to = 0, decimals = 2;
  db::PairedTest own, paper;
};

/// Means of a figure that the paper does not print, by run.
struct OtherMeans {
  std::string_view figure, name;
  double factor = 1;  ///< from SI to the printed unit
  int decimals = 2;
  Column means;  ///< in SI
};

/// What comes out by itself.
struct Findings {
  std::optional<double> c_square, c_led;  ///< mean C of the squares; of the eights that the patient leads
  std::optional<double> j_ratio;          ///< J_N of the squares by that of the eights that the therapist drives
};

struct Report {
  std::vector<Table> tables;
  std::vector<Comparison> comparisons;
  std::vector<OtherMeans> others;
  Findings findings;
};

/// Where the runs come from.
struct Origin {
  bool virtual_subjects = true;
  std::optional<std::uint64_t> seed = {};  ///< of virtual subjects, where it is known
};

[[nodiscard]] Report report_of(const Protocol& protocol, const Results& results);
/// The names of db/README.md and REST; SI; null where no value is.
[[nodiscard]] nlohmann::json report_json(const Protocol& protocol, const Results& results, const Report& report, const Origin& origin);

}  // namespace hoist::tool::study
