// hoist-gen writes every committed *.gen.* file from the tables (*.def) only. The same text for the same tables, on every
// machine.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hoist::gen {

struct GeneratedFile {
  std::string path;  // from the tree top
  std::string text;
};

// All generated files, sorted by path.
std::vector<GeneratedFile> generate_all();

// One function per kind of file; generate_all() is the list.
std::vector<GeneratedFile> typescript_files();
GeneratedFile audit_file();
GeneratedFile messages_file();
std::vector<GeneratedFile> markdown_files();
GeneratedFile dbc_file();
GeneratedFile openapi_file();
GeneratedFile rest_file();
std::vector<GeneratedFile> eds_files();

// The lock of ids: every id ever used, one per line ("param 20 lean_dead_band_norm"). A removed row stays in the lock, so that old
// recordings and stored parameters keep their meaning.
inline constexpr std::string_view kIdLockPath = "tests/contract/ids.lock";
struct IdLock {
  std::string text;                    // the lock with the ids that are new
  std::vector<std::string> conflicts;  // ids whose name is not the one they were given
};
IdLock updated_id_lock(std::string_view text);

// The shortest decimal text that reads back as the same number.
std::string number_text(double value);
// As TypeScript: a text, and one in both languages.
std::string quoted(std::string_view text);
std::string words(std::string_view english, std::string_view german);
// 0x1A00 with at least `digits` digits.
std::string hex_text(unsigned value, int digits);
// 16 hexadecimal digits.
std::string hex64(std::uint64_t value);
// The sentence that every generated file begins with, without comment marks.
std::string made_from(std::string_view table);

}  // namespace hoist::gen
