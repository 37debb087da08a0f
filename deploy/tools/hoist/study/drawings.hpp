// Figures 2, 7 and 8 of the paper as SVG.
#pragma once

#include <string>

#include "db/store/database.hpp"
#include "deploy/tools/hoist/study/results.hpp"

namespace hoist::tool::study {

/// Fig. 2: time constant while braking over the lean, for L_dec 2 to 50 (equation 6).
[[nodiscard]] std::string braking_drawing();
/// Fig. 7: the shapes that are walked.
[[nodiscard]] std::string shapes_drawing(const Protocol& protocol);
/// Fig. 8: recorded tracks (solid) over the reference (dotted), with arrows where the patient wants to turn.
[[nodiscard]] db::Result<std::string> tracks_drawing(db::Database& database, const Protocol& protocol, const Results& results);

}  // namespace hoist::tool::study
