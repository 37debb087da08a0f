// The samples of a session that count for its metrics: those in a mode in which the wheels may turn, joined in order.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

/// One control step: samples are counted, not clocked (the recorded times carry the jitter of the loop, the control law does not see it).
inline constexpr double kSample_s = 0.01;

/// Of what a figure is computed from, by name: a recorded column with the steps it is of, "gaps", "exercise". FNV-1a, 64 bits.
using InputHashes = std::map<std::string, std::uint64_t, std::less<>>;

struct MovingPart {
  InputHashes inputs;
  /// Where the hoist was: the track held against the gyroscope where the session has one (slip repaired), else the encoders' own.
  bool fused = false;
  /// Steps that were walked, or may have been, and are not recorded: those of gaps beside a moving sample.
  std::uint64_t missing_samples = 0;
  /// A new start mark, or another mode in charge, between two of the samples: they are not one walk.
  bool several_walks = false;
  bool from_mark = true;        ///< the first sample is at the start mark; false: the walk went on from an earlier recording
  std::uint64_t in_motion = 0;  ///< samples in which a wheel turned (standing_still 0)
  std::vector<std::uint64_t> tick;
  std::vector<double> x_m, y_m, psi_rad, dpsi_rad, speed_m_s;
};
Result<MovingPart> moving_part(Database& database, SessionId session);

}  // namespace hoist::db
