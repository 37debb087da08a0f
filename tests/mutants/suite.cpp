// The safety tests and the core's unit tests with one mutant in force.
//   mutant_suite --list              prints every mutant: off/FAULT, or lax/FAULT/LIMIT
//   mutant_suite --mutant MUTANT [GoogleTest's options]
// Ends with 1 at the first failure, which it names, and with 0 when no test noticed.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "control/core/base/mutation.hpp"

namespace {

using hoist::contract::Fault;
using hoist::contract::FaultInfo;
using hoist::contract::kFaults;
namespace mutation = hoist::core::mutation;

// One failure is enough; the rest of the tests is skipped.
class StopAtFirstFailure : public testing::EmptyTestEventListener {
  void OnTestStart(const testing::TestInfo& test) override { test_ = &test; }
  // GoogleTest holds its lock here, so its functions must not be called.
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (!result.failed()) return;
    std::printf("noticed by %s.%s\n", test_ == nullptr ? "?" : test_->test_suite_name(), test_ == nullptr ? "?" : test_->name());
    static_cast<void>(std::fflush(stdout));
    std::_Exit(1);
  }

  const testing::TestInfo* test_ = nullptr;
};

std::string_view name_of(Fault fault) {
  for (const FaultInfo& info : kFaults)
    if (info.bit == static_cast<std::uint8_t>(fault)) return info.name;
  return "?";
}

int list() {
  for (const FaultInfo& fault : kFaults) std::printf("off/%s\n", std::string(fault.name).c_str());
  for (std::size_t i = 0; i < mutation::limit_count; ++i)
    std::printf("lax/%s/%s\n", std::string(name_of(mutation::limits[i].fault)).c_str(), mutation::limits[i].name);
  return mutation::limit_count <= mutation::kMostLimits ? 0 : 2;
}

bool choose(std::string_view mutant) {
  for (const FaultInfo& info : kFaults)
    if (mutant == "off/" + std::string(info.name)) mutation::off_bits = hoist::contract::fault_bit(info);
  for (std::size_t i = 0; i < mutation::limit_count; ++i)
    if (mutant == "lax/" + std::string(name_of(mutation::limits[i].fault)) + "/" + mutation::limits[i].name) mutation::lax = i;
  return mutation::off_bits != 0 || mutation::lax != mutation::kMostLimits;
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const auto argument = [&](int i) { return i < argc ? std::string_view(argv[i]) : std::string_view(); };
  if (argument(1) == "--list") return list();
  if (argument(1) == "--mutant" && !choose(argument(2))) {
    std::puts("there is no such mutant (--list)");
    return 2;
  }
  testing::UnitTest::GetInstance()->listeners().Append(new StopAtFirstFailure);
  return RUN_ALL_TESTS();
}
