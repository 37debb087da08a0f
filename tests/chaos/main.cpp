// hoist-chaos: many random sessions, or one again with its story.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/chaos/session.hpp"

namespace {

using hoist::chaos::SessionOptions;
using hoist::chaos::SessionReport;

int usage() {
  std::puts(
      "hoist-chaos: random sessions in virtual time; what must always hold is checked in every step.\n"
      "  --sessions N    how many (default 200)\n"
      "  --seed S        seed of the first (default 1); the next have S + 1, S + 2, ...\n"
      "  --length S      seconds of each (default 120)\n"
      "  --no-faults     nothing breaks: then only the therapist may stop the hoist\n"
      "  --loss SHARE    of all frames that is lost, 0 to 0.2\n"
      "  --story         tell what happens in each session\n"
      "  --jobs N        sessions at a time (default: processors)");
  return 2;
}

bool number(const char* text, double& value) {
  char* end = nullptr;
  value = text == nullptr ? 0.0 : std::strtod(text, &end);
  return text != nullptr && end != text && *end == '\0' && value >= 0.0;
}

}  // namespace

int main(int argc, char** argv) {
  SessionOptions options;
  double sessions = 200, seed = 1, jobs = std::thread::hardware_concurrency();
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const char* next = i + 1 < argc ? argv[i + 1] : nullptr;
    if (word == "--no-faults") {
      options.faults_max = 0;
    } else if (word == "--story") {
      options.tell = true;
    } else if (word == "--sessions" || word == "--seed" || word == "--jobs" || word == "--length" || word == "--loss") {
      double& value = word == "--sessions" ? sessions
                      : word == "--seed"   ? seed
                      : word == "--jobs"   ? jobs
                      : word == "--length" ? options.length_s
                                           : options.frame_loss;
      if (!number(next, value)) return usage();
      ++i;
    } else {
      return usage();
    }
  }
  if (sessions < 1 || options.length_s < 15 || options.frame_loss > 0.2) return usage();

  std::atomic<std::uint64_t> next{0};
  std::mutex mutex;
  std::uint64_t bad = 0, digest = 0;
  double walked_s = 0, distance_m = 0;
  int starts = 0, stops = 0, false_stops = 0;
  const auto count = static_cast<std::uint64_t>(sessions);
  const auto work = [&] {
    for (std::uint64_t i = next++; i < count; i = next++) {
      SessionOptions mine = options;
      mine.seed = static_cast<std::uint64_t>(seed) + i;
      const SessionReport report = hoist::chaos::run_session(mine);
      const std::lock_guard lock(mutex);
      digest ^= report.digest;
      walked_s += report.walked_s;
      distance_m += report.distance_m;
      starts += report.starts;
      stops += report.stops;
      false_stops += report.false_stops;
      for (const std::string& line : report.story) std::puts(line.c_str());
      if (report.broken.empty()) continue;
      ++bad;
      for (const std::string& line : report.broken)
        std::printf("seed %llu: %s\n", static_cast<unsigned long long>(report.seed), line.c_str());
    }
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < static_cast<int>(jobs); ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  std::printf("%llu sessions of %g s: %d starts, %.1f h in motion, %.1f km, %d protective stops, %d false stops; digest %016llx\n",
              static_cast<unsigned long long>(count), options.length_s, starts, walked_s / 3600, distance_m / 1000, stops, false_stops,
              static_cast<unsigned long long>(digest));
  std::printf("%llu passed, %llu failed, 0 skipped\n", static_cast<unsigned long long>(count - bad), static_cast<unsigned long long>(bad));
  return bad == 0 ? 0 : 1;
}
