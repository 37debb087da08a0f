// "Where to add things" in README.md and its recipes name the same files, and each place that a recipe edits exists once.
// `deploy/dev check` also follows them in a copy and builds it: tests/recipes/recipes.py without --check.
#include <gtest/gtest.h>

#include "tests/support/shell.hpp"

namespace hoist::tidy {
namespace {

TEST(Recipes, ReadmeAndRecipesNameTheSamePlaces) {
  const test::ShellResult check = test::run_shell("python3 " HOIST_SOURCE_DIR "/tests/recipes/recipes.py --check 2>&1");
  EXPECT_EQ(check.exit_code, 0) << check.output;
}

}  // namespace
}  // namespace hoist::tidy
