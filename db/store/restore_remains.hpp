// Names beside the file of recordings while a restore is under way, and what removes the remains of an interrupted one.
#pragma once
#include <array>
#include <filesystem>
#include <string_view>

namespace hoist::db {

/// FILE.restore-part: the checked copy. FILE.replaced-DATE: the file that was in use.
inline constexpr std::string_view kPrepared = ".restore-part", kReplacedInfix = ".replaced-";
/// What goes with a file that is set aside.
inline constexpr std::array kKeptWith{"-wal", ".seal"};

/// Removes the checked copy and a second name of the file itself. Call it before the file is opened.
void tidy_after_restore(const std::filesystem::path& file);

}  // namespace hoist::db
