// hoist-fuzz: the targets under libFuzzer. The target is named by the environment variable HOIST_FUZZ_TARGET;
// `--list` prints the names, `--seeds FOLDER` writes the good inputs of the target there and ends.
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/fuzz/targets.hpp"

namespace {
const hoist::fuzz::Target* chosen = nullptr;
}

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  const std::string first = *argc > 1 ? (*argv)[1] : "";
  if (first == "--list") {
    for (const auto& target : hoist::fuzz::targets()) std::printf("%.*s\n", static_cast<int>(target.name.size()), target.name.data());
    std::exit(0);
  }
  const char* name = std::getenv("HOIST_FUZZ_TARGET");
  for (const auto& target : hoist::fuzz::targets())
    if (name != nullptr && target.name == name) chosen = &target;
  if (chosen == nullptr) {
    std::fprintf(stderr, "hoist-fuzz: HOIST_FUZZ_TARGET must be one of those that --list names\n");
    std::exit(2);
  }
  if (first == "--seeds" && *argc > 2) {
    int number = 0;
    for (const auto& seed : chosen->seeds()) {
      std::ofstream file(std::string((*argv)[2]) + "/seed-" + std::to_string(number++), std::ios::binary);
      file.write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
    }
    std::exit(0);
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  chosen->run({data, size});
  return 0;
}
