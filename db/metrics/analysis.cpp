#include "db/metrics/analysis.hpp"

#include <utility>

namespace hoist::db {

void Analyser::add(const WalkSample& sample) {
  const std::uint64_t before = std::exchange(tick_, sample.tick);
  if (first_) out_.walk.add(sample);
  if (!counts(sample)) return;
  rhythm_.add(sample);
  lead_.add(sample);
  if (!first_) return;
  // Several walks are not compared.
  std::optional<double> s_m;
  if (!out_.walk.several_walks) s_m = comparer_.add(sample, out_.walk.from_mark);
  task_.add(sample, s_m, before);
  bouts_.add(sample);
  turns_.add(sample);
}

bool Analyser::again() {
  first_ = false;
  const bool rhythm = rhythm_.again(), lead = lead_.again();
  return rhythm || lead;
}

Analysis Analyser::result() {
  out_.comparison = comparer_.result(out_.walk);
  out_.bouts = bouts_.end();
  out_.turns = turns_.end();
  out_.rhythm = rhythm_.result(out_.walk, out_.bouts.count > 0);
  out_.task = task_.result(out_.walk, out_.comparison);
  out_.lead = lead_.result(out_.walk);
  return std::move(out_);
}

}  // namespace hoist::db
