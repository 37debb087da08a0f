// Runs the tests linked into it with one mutant in force.
//   HOIST_MUTANT=N       the number from mutate.py's list; none without it
//   HOIST_MUTANT_MAP=F   writes to F, for each test, how long it took and which mutants' places it came by: "suite.test<tab>ms<tab>number number ..."
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "tests/mutants/mutant_switch.hpp"

namespace {

class Map : public testing::EmptyTestEventListener {
 public:
  explicit Map(const char* path) : out_(path) {}

 private:
  void OnTestStart(const testing::TestInfo&) override { std::fill_n(hoist_mutants::reached, hoist_mutants::kMost, false); }
  void OnTestEnd(const testing::TestInfo& test) override {
    out_ << test.test_suite_name() << '.' << test.name() << '\t' << test.result()->elapsed_time() << '\t';
    for (int number = 0; number < hoist_mutants::kMost; ++number)
      if (hoist_mutants::reached[number]) out_ << number << ' ';
    out_ << '\n';
  }
  std::ofstream out_;
};

}  // namespace

int main(int count, char** arguments) {
  testing::InitGoogleTest(&count, arguments);
  if (const char* number = std::getenv("HOIST_MUTANT")) hoist_mutants::chosen = std::atoi(number);
  if (const char* path = std::getenv("HOIST_MUTANT_MAP")) testing::UnitTest::GetInstance()->listeners().Append(new Map(path));
  return RUN_ALL_TESTS();
}
