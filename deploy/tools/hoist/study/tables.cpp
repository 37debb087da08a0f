#include "deploy/tools/hoist/study/tables.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace hoist::tool::study {

namespace {

std::string text(const std::optional<double>& value, int decimals) {
  if (!value) return "      -";
  std::array<char, 32> out{};
  std::snprintf(out.data(), out.size(), "%7.*f", decimals, *value);
  return out.data();
}

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

std::string heading(const Protocol& protocol) {
  std::string line = padded("subject", 10);
  for (int side = 0; side < 2; ++side) {
    line += side == 1 ? "   | paper" : "";
    for (const Run& run : protocol.runs) {
      const std::string name =
          std::to_string(run.number) + (run.shape == contract::ExerciseShape::square ? "sq" : "") + (run.by_patient ? "*" : "");
      line += std::string(side == 1 && &run == &protocol.runs.front() ? 1 : 7 - std::min<std::size_t>(7, name.size()), ' ') + name;
    }
  }
  return line + "\n";
}

std::string row_of(int decimals, const std::string& name, const Column& own, const Column& paper) {
  std::string line = padded(name, 10);
  for (const auto& value : own) line += text(value, decimals);
  line += "   |";
  for (const auto& value : paper) line += text(value, decimals);
  return line + "\n";
}

Column row_at(const std::vector<Column>& columns, std::size_t row) {
  Column out;
  for (const Column& column : columns) out.push_back(column[row]);
  return out;
}

std::string table_text(const Protocol& protocol, const Table& table) {
  std::string out = std::string(table.title) + "\n" + heading(protocol);
  for (std::size_t row = 0; row < table.subjects.size(); ++row)
    out += row_of(table.decimals, table.subjects[row], row_at(table.own, row), row_at(table.paper, row));
  return out + row_of(table.decimals, "mean", table.own_mean, table.paper_mean) +
         "(means over the subjects present; * led by the patient, sq: square)\n\n";
}

std::string test_text(const db::PairedTest& test, int decimals) {
  if (test.pairs == 0) return "no subject did both";
  std::array<char, 160> out{};
  std::snprintf(out.data(), out.size(), "%.*f -> %.*f, %zu of %zu up, %zu down", decimals, test.mean_first, decimals, test.mean_second,
                test.up, test.pairs, test.down);
  std::string line = out.data();
  if (!test.p) return line;
  std::snprintf(out.data(), out.size(), ", p %.3f", *test.p);
  return line + out.data();
}

std::string other_means(const Report& report) {
  std::string out = "Means of other figures\n";
  for (const OtherMeans& one : report.others) {
    out += padded("  " + std::string(one.name), 28);
    for (std::optional<double> mean : one.means) {
      if (mean) *mean *= one.factor;
      out += text(mean, one.decimals);
    }
    out += "\n";
  }
  return out + "\n";
}

std::string range_text(const Range& range, int decimals) {
  std::array<char, 64> out{};
  std::snprintf(out.data(), out.size(), "%.*f to %.*f", decimals, range[0], decimals, range[1]);
  return out.data();
}

}  // namespace

std::string tables(const Protocol& protocol, const Results& results, const Report& report) {
  std::string out;
  for (const Table& table : report.tables) out += table_text(protocol, table);
  out += "Paired (subjects who did both; Wilcoxon's signed ranks, two-sided, exact)\n";
  for (const Comparison& one : report.comparisons)
    out += "  " + padded(std::string(one.figure) + ", " + std::to_string(one.from) + " -> " + std::to_string(one.to), 14) +
           padded(test_text(one.own, one.decimals), 52) + "| paper " + test_text(one.paper, one.decimals) + "\n";
  out += "\n" + other_means(report);
  if (results.left_out.empty()) return out;
  out += "Left out\n";
  for (const LeftOut& one : results.left_out) out += "  " + sentence(one) + "\n";
  return out + "\n";
}

std::string assumptions_and_findings(const Protocol& protocol, const Report& report) {
  const Assumptions& a = protocol.assumed;
  std::array<char, 640> line{};
  std::string out = "Put in by assumption, no finding\n";
  std::snprintf(
      line.data(), line.size(),
      "  preferred speed %s m/s; preset \"%s\"; comfort and reach follow its ranges\n"
      "  a subject who follows turns to the line ahead by %s of what a leading one would, %.2f more with each run done, and trails\n"
      "  %.2f s behind the hoist (chosen for a C of the paper's size): so C of the therapist's runs and its rise from run to run\n"
      "  the therapist sees %.2f s late, %.2f m and %.1f degrees off: so J_N of the therapist's runs\n"
      "  the orthosis: asymmetry of steps %.2f, sway %.1f times as wide\n",
      range_text(a.wish_m_s, 2).c_str(), protocol.preset.c_str(), range_text(a.anticipation_norm, 2).c_str(), a.learning_norm, a.trailing_s,
      a.therapist_delay_s, a.misjudgement_m, a.misjudgement_rad * 57.29577951308232, a.limp_norm, a.injured_sway_norm);
  out += line.data();
  out += "Comes out\n";
  const Findings& found = report.findings;
  if (found.c_square) out += "  C of the squares" + text(found.c_square, 2) + ": their path turns in the corners only, for a moment\n";
  if (found.c_led) out += "  C while the patient leads" + text(found.c_led, 2) + ": the pelvis steers\n";
  if (found.j_ratio)
    out += "  J_N of the squares" + text(found.j_ratio, 1) + " times that of the therapist's eights: nobody turns on the spot\n";
  return out;
}

}  // namespace hoist::tool::study
