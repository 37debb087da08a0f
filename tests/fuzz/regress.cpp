// Each target with its good inputs, with every input that was ever found to break one (corpus/NAME), and with mutations of all of them from
// a fixed seed: the same run on every machine.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "control/contract/faults.hpp"
#include "tests/fuzz/targets.hpp"

namespace hoist::fuzz {
namespace {

constexpr int kMutations = 20000;
constexpr std::size_t kInputMax = 4096;

std::vector<Input> kept_inputs(const Target& target) {
  std::vector<Input> inputs;
  const std::filesystem::path folder = std::filesystem::path(HOIST_SOURCE_DIR) / "tests/fuzz/corpus" / target.name;
  if (!std::filesystem::exists(folder)) return inputs;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return inputs;
}

void mutate(Input& input, std::mt19937& random, const std::vector<Input>& others) {
  const auto below = [&random](std::size_t limit) { return limit == 0 ? 0 : static_cast<std::size_t>(random()) % limit; };
  static constexpr std::uint8_t kTelling[] = {0x00, 0x01, 0x7F, 0x80, 0xFF, '\r', '\a', '-', '9', '{', '"'};
  const std::size_t steps = 1 + below(6);
  for (std::size_t step = 0; step < steps; ++step) {
    const std::size_t at = below(input.size());
    switch (below(7)) {
      case 0:
        if (!input.empty()) input[at] = static_cast<std::uint8_t>(input[at] ^ (1U << below(8)));
        break;
      case 1:
        if (!input.empty()) input[at] = kTelling[below(std::size(kTelling))];
        break;
      case 2:
        input.insert(input.begin() + static_cast<std::ptrdiff_t>(at), static_cast<std::uint8_t>(random()));
        break;
      case 3:
        if (!input.empty()) input.erase(input.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      case 4:
        input.resize(at);
        break;
      case 5: {
        const Input& other = others[below(others.size())];
        const std::size_t from = below(other.size());
        input.insert(input.end(), other.begin() + static_cast<std::ptrdiff_t>(from), other.end());
        break;
      }
      default: {
        const Input piece(input.begin() + static_cast<std::ptrdiff_t>(at), input.end());
        input.insert(input.end(), piece.begin(), piece.end());
      }
    }
    if (input.size() > kInputMax) input.resize(kInputMax);
  }
}

class FuzzTarget : public ::testing::TestWithParam<Target> {};

TEST_P(FuzzTarget, SurvivesKeptAndMutatedInputs) {
  const Target& target = GetParam();
  std::vector<Input> inputs = target.seeds();
  ASSERT_FALSE(inputs.empty()) << "a target without a good input proves nothing";
  for (Input& kept : kept_inputs(target)) inputs.push_back(std::move(kept));
  target.run({});
  for (const Input& input : inputs) target.run(input);
  std::mt19937 random(20261121);
  for (int i = 0; i < kMutations; ++i) {
    Input input = inputs[static_cast<std::size_t>(random()) % inputs.size()];
    mutate(input, random, inputs);
    target.run(input);
  }
}

// What the core targets promise about motion would hold of a hoist that never moves.
TEST(CoreTargets, DriveInEachModeThatMoves) {
  for (const Target& target :
       {Target{"core_frames", fuzz_core_frames, seeds_core_frames}, {"core_commands", fuzz_core_commands, seeds_core_commands}}) {
    core_modes_driven = 0;
    for (const Input& input : target.seeds()) target.run(input);
    for (const contract::ModeInfo& mode : contract::kModes)
      EXPECT_TRUE(!mode.moving || (core_modes_driven >> mode.value & 1U) != 0) << target.name << " never drives in " << mode.name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, FuzzTarget, ::testing::ValuesIn(targets()), [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace hoist::fuzz
