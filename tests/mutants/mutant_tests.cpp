// Runs the tests linked into it with one mutant in force.
//   HOIST_MUTANT=N       the number from mutate.py's list; none without it
//   HOIST_MUTANT_MAP=F   writes to F, for each test, its processor time and which mutants' places it came by:
//                        "suite.test<tab>ms<tab>number number ..."
#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <fstream>

#include "tests/mutants/mutant_switch.hpp"

namespace {

class Map : public testing::EmptyTestEventListener {
 public:
  explicit Map(const char* path) : out_(path) {}

 private:
  void OnTestStart(const testing::TestInfo&) override {
    std::fill_n(hoist_mutants::reached, hoist_mutants::kMost, false);
    begin_ = std::clock();
  }
  void OnTestEnd(const testing::TestInfo& test) override {
    // Processor time: on a busy machine a test is no longer than elsewhere.
    out_ << test.test_suite_name() << '.' << test.name() << '\t' << (std::clock() - begin_) * 1000 / CLOCKS_PER_SEC << '\t';
    for (int number = 0; number < hoist_mutants::kMost; ++number)
      if (hoist_mutants::reached[number]) out_ << number << ' ';
    out_ << '\n';
  }
  std::ofstream out_;
  std::clock_t begin_ = 0;
};

}  // namespace

int main(int count, char** arguments) {
  testing::InitGoogleTest(&count, arguments);
  if (const char* number = std::getenv("HOIST_MUTANT")) hoist_mutants::chosen = std::atoi(number);
  if (const char* path = std::getenv("HOIST_MUTANT_MAP")) testing::UnitTest::GetInstance()->listeners().Append(new Map(path));
  return RUN_ALL_TESTS();
}
