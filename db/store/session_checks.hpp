// The limits of what people may write into a session; one place for recorder and editor. check_exercise is in store/exercise_json.hpp.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "db/store/result.hpp"
#include "db/store/session_reader.hpp"

namespace hoist::db {

Status check_subject(const std::optional<std::string>& subject);
Status check_note(std::string_view note);

}  // namespace hoist::db
