// Why a parameter is another than before, in one word: `reason` of the log of parameters, `how` of REST.
#pragma once
#include <array>
#include <string_view>

namespace hoist::db {

/// Each parameter's first row: no change, and in no list.
inline constexpr std::string_view kFirstSeen = "first_seen";
/// Changed while no server wrote it down.
inline constexpr std::string_view kNotSeen = "not_seen";
/// `undo`: a person took a trial back; `trial_over`: it was not kept in time.
inline constexpr std::array<std::string_view, 9> kChangeReasons{"set",        "trial",   "preset",      "profile", "undo",
                                                                "trial_over", "neutral", "calibration", kNotSeen};

}  // namespace hoist::db
