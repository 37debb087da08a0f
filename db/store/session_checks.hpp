// The limits of what people may write into a session; one place for recorder and editor. check_exercise is in store/exercise_json.hpp.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "db/store/result.hpp"
#include "db/store/session_reader.hpp"

namespace hoist::db {

/// What a recording can hold. What people may type is narrower (patient_code.hpp): a walk is never refused for its patient's older code.
Status check_subject(const std::optional<std::string>& subject);
Status check_note(std::string_view note);
Status check_marker(std::string_view text);
/// One of kMarkerKinds.
Status check_marker_kind(std::string_view kind);
/// Whole UTF-8 in one line, without control characters, at most so many bytes.
bool is_plain_line(std::string_view text, std::size_t most_bytes);

}  // namespace hoist::db
