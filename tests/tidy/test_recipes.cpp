// "Where to add things" in README.md and its recipes name the same files, and each place that a recipe edits exists once.
// `deploy/dev check` also follows them in a copy and builds it: tests/recipes/recipes.py without --check.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace hoist::tidy {
namespace {

TEST(Recipes, ReadmeAndRecipesNameTheSamePlaces) {
  const std::string command = "python3 " HOIST_SOURCE_DIR "/tests/recipes/recipes.py --check 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string told;
  char buffer[4096];
  for (std::size_t got = 0; (got = fread(buffer, 1, sizeof buffer, pipe)) > 0;) told.append(buffer, got);
  EXPECT_EQ(pclose(pipe), 0) << told;
}

}  // namespace
}  // namespace hoist::tidy
