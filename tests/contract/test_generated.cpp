// Generated files match the tables, and an id keeps its meaning.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "control/contract/shared_memory.hpp"
#include "deploy/tools/gen/generate.hpp"

namespace hoist::gen {
namespace {

std::string content_of(const std::string& path) {
  std::ifstream in(std::filesystem::path(HOIST_SOURCE_DIR) / path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

TEST(Generated, FilesAreUpToDate) {
  for (const auto& file : generate_all())
    EXPECT_TRUE(content_of(file.path) == file.text) << file.path << " is out of date: run deploy/dev gen";
}

TEST(Generated, NoFileIsLeftBehindByARemovedGenerator) {
  std::set<std::string> expected;
  for (const auto& file : generate_all()) expected.insert(file.path);
  for (const std::string folder : {"control", "db", "firmware", "web/src", "server"}) {
    const auto top = std::filesystem::path(HOIST_SOURCE_DIR);
    if (!std::filesystem::exists(top / folder)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(top / folder)) {
      const auto path = std::filesystem::relative(entry.path(), top).generic_string();
      if (path.find(".gen.") == std::string::npos) continue;
      // Measured ones are made by a verb of their own, which they name.
      const std::string text = content_of(path), made_by = text.substr(0, text.find('\n'));
      if (made_by.rfind("<!-- Made by `deploy/dev ", 0) == 0 && made_by.find("`deploy/dev gen`") == std::string::npos) continue;
      EXPECT_EQ(expected.count(path), 1U) << path << " is made by nothing";
    }
  }
}

TEST(Generated, IsTheSameEachTime) {
  const auto first = generate_all();
  const auto second = generate_all();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_TRUE(first[i].path == second[i].path && first[i].text == second[i].text) << first[i].path;
}

TEST(Generated, NumbersReadBackAsTheSameNumber) {
  for (const double value : {0.0, 0.1, 1.0 / 3.0, -0.0013, 1e-5, 0.174532925, 4294967295.0})
    EXPECT_EQ(std::stod(number_text(value)), value);
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(hex_text(0x1A, 4), "0x001A");
}

TEST(IdLock, HoldsEveryIdOfTheTables) {
  const auto text = content_of(std::string(kIdLockPath));
  const auto lock = updated_id_lock(text);
  EXPECT_TRUE(lock.conflicts.empty()) << lock.conflicts.front() << ": an id is never reused";
  EXPECT_TRUE(lock.text == text) << "new ids are not in the lock yet: run deploy/dev gen";
}

TEST(IdLock, ReusedIdsAreFoundAndRetiredOnesKept) {
  const auto lock = updated_id_lock("param 1 some_other_name\nparam 9999 long_gone\n");
  ASSERT_EQ(lock.conflicts.size(), 1U);
  EXPECT_NE(lock.conflicts.front().find("some_other_name"), std::string::npos);
  EXPECT_NE(lock.text.find("param 9999 long_gone\n"), std::string::npos);
  // What was written once is accepted as it is.
  EXPECT_EQ(updated_id_lock(updated_id_lock("").text).text, updated_id_lock("").text);
  EXPECT_TRUE(updated_id_lock(updated_id_lock("").text).conflicts.empty());
}

TEST(Layout, HashIsTold) {
  const auto hash = contract::layout_hash();
  RecordProperty("layout_hash", std::to_string(hash));
  EXPECT_NE(hash, contract::kHashStart);
  // A changed name, unit, order or size must change the hash: one step of the hash does.
  EXPECT_NE(contract::hash_bytes(contract::kHashStart, "speed_m_s"), contract::hash_bytes(contract::kHashStart, "speed_m"));
  EXPECT_NE(contract::hash_number(contract::kHashStart, 8), contract::hash_number(contract::kHashStart, 16));
}

}  // namespace
}  // namespace hoist::gen
