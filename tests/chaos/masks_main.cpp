// hoist-chaos-masks: how many random sessions the judge needs to find each monitor of the core that is switched off.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "tests/chaos/masks.hpp"

namespace {

int usage() {
  std::fputs(
      "hoist-chaos-masks: each monitor switched off in turn; sessions run until the judge fails one\n"
      "  --sessions N     at most so many for each (default 2000)\n"
      "  --seed S         seed of the first (default 1)\n"
      "  --monitor NAME   only this one\n"
      "  --jobs N         sessions at a time (default: processors)\n",
      stderr);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t most = 2000, first = 1, jobs = std::max(1U, std::thread::hardware_concurrency());
  std::string only;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (i + 1 == argc) return usage();
    const char* value = argv[++i];
    if (word == "--monitor") {
      only = value;
      continue;
    }
    std::uint64_t& number = word == "--sessions" ? most : word == "--seed" ? first : jobs;
    if (word != "--sessions" && word != "--seed" && word != "--jobs") return usage();
    number = std::strtoull(value, nullptr, 10);
    if (number == 0) return usage();
  }
  std::size_t found = 0, tried = 0;
  std::puts("# monitor\tsessions\tthe one that found it\tfirst violation");
  for (const hoist::contract::Fault fault : hoist::chaos::masks()) {
    const std::string name(hoist::contract::fault_info(fault).name);
    if (!only.empty() && only != name) continue;
    ++tried;
    const hoist::chaos::MaskResult result = hoist::chaos::run_masked(fault, first, most, static_cast<unsigned>(jobs));
    if (result.found) {
      ++found;
      std::printf("%s\t%llu\t%s\t%s\n", name.c_str(), static_cast<unsigned long long>(result.sessions), result.replay.c_str(),
                  result.found->broken.front().c_str());
    } else {
      std::printf("%s\t%llu\t-\tNOT FOUND\n", name.c_str(), static_cast<unsigned long long>(result.sessions));
    }
    std::fflush(stdout);
  }
  std::printf("# %zu of %zu monitors found off\n", found, tried);
  return found == tried && tried > 0 ? 0 : 1;
}
