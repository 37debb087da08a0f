#include "tests/chaos/shrink.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "firmware/sim/patient_family.hpp"

namespace hoist::chaos {
namespace {

constexpr double kShortest_s = 15.0;
constexpr double kAfter_s = 1.0;  // time kept after the violation

// "I1: a wheel ..." is I1: a smaller session counts when it violates the same invariant.
std::string promise(const SessionReport& report) {
  if (report.broken.empty()) return {};
  const std::string& line = report.broken.front();
  const std::size_t at = line.find(':');
  const std::size_t begin = at == std::string::npos ? 0 : line.find_last_of(' ', at) + 1;
  return line.substr(begin, at == std::string::npos ? at : at - begin);
}

}  // namespace

SessionOptions shrink(const SessionOptions& options, const SessionReport& report) {
  SessionOptions best = options;
  best.tell = false;
  best.faults = report.faults;
  best.patient = report.patient;
  const std::string wanted = promise(report);
  int runs = 0;
  const auto breaks = [&](const SessionOptions& tried, SessionReport& found) {
    if (++runs > kShrinkRuns) return false;
    found = tried.only_walk ? run_unmoved(tried) : run_session(tried);
    return !found.broken.empty() && promise(found) == wanted;
  };
  SessionReport newest = report;
  for (bool smaller = true; smaller && runs < kShrinkRuns;) {
    smaller = false;
    for (std::size_t i = 0; i < best.faults->size(); ++i) {
      SessionOptions tried = best;
      tried.faults->erase(tried.faults->begin() + static_cast<std::ptrdiff_t>(i));
      SessionReport found;
      if (!breaks(tried, found)) continue;
      best = tried;
      newest = found;
      smaller = true;
      break;
    }
    // What has not begun when it broke is not needed; what comes after is not either.
    const double until_s = std::max(kShortest_s, std::ceil(newest.broken_s + kAfter_s));
    if (until_s < best.length_s) {
      SessionOptions tried = best;
      tried.length_s = until_s;
      SessionReport found;
      if (breaks(tried, found)) {
        best = tried;
        newest = found;
        smaller = true;
      }
    }
    for (std::size_t i = 0; i < best.faults->size() && !smaller; ++i) {
      SessionOptions tried = best;
      Fault& fault = (*tried.faults)[i];
      const double length_s = fault.end_s - fault.start_s;
      if (length_s < 0.1) continue;
      fault.end_s = fault.start_s + std::round(length_s * 500.0) / 1000.0;
      SessionReport found;
      if (!breaks(tried, found)) continue;
      best = tried;
      newest = found;
      smaller = true;
    }
  }
  return best;
}

std::string replay_words(const SessionOptions& options) {
  std::ostringstream text;
  if (options.only_walk) text << "--unmoved ";
  text << "--seed " << options.seed << " --length " << options.length_s;
  // Ten digits, so that a printed number reads back unchanged.
  text.precision(10);
  if (options.frame_loss != 0) text << " --loss " << options.frame_loss;
  if (options.link_jitter_s != 0) text << " --jitter " << options.link_jitter_s;
  if (const std::string patient = patient_of(options); patient != kEvenPatient) text << " --patient " << patient;
  text << " --faults ";
  return text.str() + faults_text(options.faults ? *options.faults
                                                 : plan_faults(options.seed, options.faults_max, options.length_s, options.outside_only));
}

std::optional<SessionOptions> read_replay(const std::string& words) {
  std::istringstream in(words);
  SessionOptions options;
  const auto number = [](const std::string& text, double& value) {
    char* end = nullptr;
    value = std::strtod(text.c_str(), &end);
    return end != text.c_str() && *end == '\0' && value >= 0;
  };
  for (std::string word, value; in >> word;) {
    if (word == "--unmoved") {
      options.only_walk = options.outside_only = true;
      continue;
    }
    double seed = 0;
    if (!(in >> value)) return std::nullopt;
    if (word == "--faults") {
      options.faults = read_faults(value);
      if (!options.faults) return std::nullopt;
    } else if (word == "--patient" && sim::find_patient(value) != nullptr) {
      options.patient = value;
    } else if (word == "--seed" && number(value, seed)) {
      options.seed = static_cast<std::uint64_t>(seed);
    } else if (!(word == "--length" && number(value, options.length_s)) && !(word == "--loss" && number(value, options.frame_loss)) &&
               !(word == "--jitter" && number(value, options.link_jitter_s))) {
      return std::nullopt;
    }
  }
  return options.faults ? std::optional(options) : std::nullopt;
}

}  // namespace hoist::chaos
