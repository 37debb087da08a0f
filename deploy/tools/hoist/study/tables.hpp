// Tables II and III as text, the paper's beside them, and the paired tests.
#pragma once

#include <string>

#include "deploy/tools/hoist/study/report.hpp"

namespace hoist::tool::study {

[[nodiscard]] std::string tables(const Protocol& protocol, const Results& results, const Report& report);
/// What is put in by assumption, and what comes out.
[[nodiscard]] std::string assumptions_and_findings(const Protocol& protocol, const Report& report);

}  // namespace hoist::tool::study
