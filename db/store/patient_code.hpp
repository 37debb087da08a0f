// THE rule for patient codes, the same for REST, console, recorder and archive. It cannot tell a code from a name; screens ask for codes. Codes from
// before the rule stay as they are and go on being recorded.
#pragma once
#include <string>
#include <string_view>

#include "db/store/result.hpp"

struct sqlite3;

namespace hoist::db {

inline constexpr std::size_t kMaxCode_chars = 32;
inline constexpr std::string_view kCodeRule = "1 to 32 letters, digits, dots, hyphens or underscores, beginning with a letter or digit";

/// Without spaces and tabs around it.
std::string trimmed_code(std::string_view typed);
/// bad_value with this field unless a new patient may have this code.
Status check_code(std::string_view code, const char* field);
/// Capital and small letters do not tell codes apart.
bool same_code(std::string_view one, std::string_view other);
/// The code of the patient who is meant by these letters; empty when there is none. Throws SqlFailure.
std::string stored_code(sqlite3* handle, std::string_view code);
/// The code to record for what was typed: that of the patient who is meant, or a new one by the rule. Errors: bad_value (field), corrupt, busy.
Result<std::string> code_to_record(sqlite3* handle, std::string_view typed, const char* field);

}  // namespace hoist::db
