#include "deploy/tools/hoist/study/tables.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "db/metrics/paired_test.hpp"

namespace hoist::tool::study {

namespace {

constexpr std::size_t kPaperSubjects = 11, kPaperRuns = 6;
constexpr double kNo = -9;  // a dash in the paper
using PaperTable = std::array<std::array<double, kPaperRuns>, kPaperSubjects>;

// As printed, page 8.
constexpr PaperTable kTableII{{{0.09, 0.60, 0.95, kNo, kNo, kNo},
                               {-0.05, 0.23, 0.91, kNo, kNo, kNo},
                               {0.05, 0.42, 0.86, 0.11, 0.47, 0.92},
                               {0.15, 0.76, 0.91, 0.10, 0.88, 0.91},
                               {0.06, 0.49, 0.77, 0.10, 0.65, 0.81},
                               {0.01, 0.18, 0.70, 0.14, 0.69, 0.92},
                               {0.09, 0.39, 0.89, 0.11, 0.45, 0.87},
                               {0.05, 0.24, 0.91, kNo, kNo, kNo},
                               {0.10, 0.70, 0.86, kNo, kNo, kNo},
                               {0.12, 0.35, 0.86, 0.12, 0.51, 0.93},
                               {0.12, 0.56, 0.95, 0.11, 0.77, 0.91}}};
constexpr PaperTable kTableIII{{{30.35, 9.42, 3.78, kNo, kNo, kNo},
                                {32.38, 8.41, 5.88, kNo, kNo, kNo},
                                {30.57, 29.73, 3.56, 30.92, 5.58, 2.12},
                                {36.93, 4.06, 3.41, 110.63, 11.12, 3.61},
                                {50.06, 6.80, 17.80, 31.17, 13.30, 9.87},
                                {29.83, 3.58, 7.05, 72.55, 3.63, 7.79},
                                {30.34, 5.01, 7.29, 32.15, 12.39, 4.43},
                                {10.64, 6.84, 5.05, kNo, kNo, kNo},
                                {31.79, 24.76, 4.78, kNo, kNo, kNo},
                                {34.96, 14.36, 6.62, 40.52, 31.22, 7.40},
                                {74.01, 12.20, 8.68, 78.78, 8.58, 7.72}}};

Column paper_column(const PaperTable& table, int run) {
  Column out;
  if (run < 1 || run > static_cast<int>(kPaperRuns)) return out;
  for (const auto& row : table) {
    const double value = row[static_cast<std::size_t>(run) - 1];
    out.push_back(value == kNo ? std::nullopt : std::optional{value});
  }
  return out;
}

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

struct Told {
  std::string_view figure, title;
  const PaperTable* paper;
  int decimals;
};
constexpr Told kTables[] = {
    {"C", "Table II: C at zero lag, pelvis turn against the path's turn (higher is better)", &kTableII, 2},
    {"J_N", "Table III: J_N, squared error per metre of path at 100 Hz (lower is better)", &kTableIII, 2},
};

std::string row_of(const Protocol& protocol, const Told& told, const std::string& name, const std::vector<std::optional<double>>& own,
                   const std::vector<std::optional<double>>& paper) {
  std::string line = padded(name, 10);
  for (const auto& value : own) line += text(value, told.decimals);
  line += "   |";
  for (std::size_t i = 0; i < protocol.runs.size(); ++i) line += text(paper[i], told.decimals);
  return line + "\n";
}

std::string table(const Protocol& protocol, const Results& results, const Told& told) {
  std::string out = std::string(told.title) + "\n" + heading(protocol);
  const std::size_t rows = std::max(results.subjects.size(), kPaperSubjects);
  for (std::size_t row = 0; row < rows; ++row) {
    std::vector<std::optional<double>> own, paper;
    for (const Run& run : protocol.runs) {
      const Column printed = paper_column(*told.paper, run.number);
      own.push_back(row < results.subjects.size() ? results.column(told.figure, run.number)[row] : std::nullopt);
      paper.push_back(row < printed.size() ? printed[row] : std::nullopt);
    }
    out += row_of(protocol, told, row < results.subjects.size() ? results.subjects[row] : "-", own, paper);
  }
  std::vector<std::optional<double>> own, paper;
  for (const Run& run : protocol.runs) {
    own.push_back(mean_of(results.column(told.figure, run.number)));
    paper.push_back(mean_of(paper_column(*told.paper, run.number)));
  }
  return out + row_of(protocol, told, "mean", own, paper) + "(means over the subjects present; * led by the patient, sq: square)\n\n";
}

std::string test_text(const Column& first, const Column& second, int decimals) {
  const db::PairedTest test = db::paired_test(first, second);
  if (test.pairs == 0) return "no subject did both";
  std::array<char, 160> out{};
  std::snprintf(out.data(), out.size(), "%.*f -> %.*f, %zu of %zu up, %zu down", decimals, test.mean_first, decimals, test.mean_second,
                test.up, test.pairs, test.down);
  std::string line = out.data();
  if (!test.p) return line;
  std::snprintf(out.data(), out.size(), ", p %.3f", *test.p);
  return line + out.data();
}

std::string other_means(const Protocol& protocol, const Results& results) {
  struct Row {
    std::string_view figure, name;
    double factor;
    int decimals;
  };
  std::string out = "Means of other figures\n";
  for (const Row& row : {Row{"C_best", "C at its best lag", 1, 2}, Row{"rms_position_m", "path error RMS, cm", 100, 1},
                         Row{"rms_heading_rad", "heading error RMS, deg", 57.29577951308232, 1},
                         Row{"walking_speed_m_s", "speed while walking, m/s", 1, 3}, Row{"lap_time_mean_s", "time for a lap, s", 1, 1}}) {
    out += padded("  " + std::string(row.name), 28);
    for (const Run& run : protocol.runs) {
      std::optional<double> mean = mean_of(results.column(row.figure, run.number));
      if (mean) *mean *= row.factor;
      out += text(mean, row.decimals);
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

// The mean over all subjects and those runs.
std::optional<double> mean_where(const Protocol& protocol, const Results& results, std::string_view figure, bool square, bool by_patient) {
  Column all;
  for (const Run& run : protocol.runs) {
    if ((run.shape == contract::ExerciseShape::square) != square || run.by_patient != by_patient) continue;
    const Column& column = results.column(figure, run.number);
    all.insert(all.end(), column.begin(), column.end());
  }
  return mean_of(all);
}

}  // namespace

std::string tables(const Protocol& protocol, const Results& results) {
  std::string out;
  for (const Told& told : kTables) out += table(protocol, results, told);
  out += "Paired (subjects who did both; Wilcoxon's signed ranks, two-sided, exact)\n";
  for (const auto& [first, second] : protocol.compared) {
    for (const Told& told : kTables) {
      out += "  " + padded(std::string(told.figure) + ", " + std::to_string(first) + " -> " + std::to_string(second), 14) +
             padded(test_text(results.column(told.figure, first), results.column(told.figure, second), told.decimals), 52) + "| paper " +
             test_text(paper_column(*told.paper, first), paper_column(*told.paper, second), told.decimals) + "\n";
    }
  }
  out += "\n" + other_means(protocol, results);
  if (results.left_out.empty()) return out;
  out += "Left out\n";
  for (const std::string& line : results.left_out) out += "  " + line + "\n";
  return out + "\n";
}

std::string assumptions_and_findings(const Protocol& protocol, const Results& results) {
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
  const auto c_square = mean_where(protocol, results, "C", true, false), c_led = mean_where(protocol, results, "C", false, true);
  const auto j_square = mean_where(protocol, results, "J_N", true, false), j_eight = mean_where(protocol, results, "J_N", false, false);
  if (c_square) out += "  C of the squares" + text(c_square, 2) + ": their path turns in the corners only, for a moment\n";
  if (c_led) out += "  C while the patient leads" + text(c_led, 2) + ": the pelvis steers\n";
  if (j_square && j_eight)
    out += "  J_N of the squares" + text(*j_square / *j_eight, 1) + " times that of the therapist's eights: nobody turns on the spot\n";
  return out;
}

}  // namespace hoist::tool::study
