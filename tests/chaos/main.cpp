// hoist-chaos: many random sessions, or one again with its story.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "control/contract/faults.hpp"
#include "firmware/sim/patient_family.hpp"
#include "tests/chaos/session.hpp"
#include "tests/chaos/shrink.hpp"

namespace {

using hoist::chaos::SessionOptions;
using hoist::chaos::SessionReport;

// A piece of a long run: after each one the state is written down.
constexpr std::uint64_t kPiece = 50;
// Of more broken ones the seed is enough.
constexpr std::uint64_t kShrunkMost = 5;

void usage(std::FILE* to) {
  std::fputs(
      "hoist-chaos: random sessions in virtual time; what must always hold is checked in every step.\n"
      "  --sessions N    how many (default 200)\n"
      "  --seed S        seed of the first (default 1); the next have S + 1, S + 2, ...\n"
      "  --length S      seconds of each (default 120)\n"
      "  --no-faults     nothing breaks: then only the therapist may stop the hoist\n"
      "  --loss SHARE    of all frames that is lost, 0 to 0.2\n"
      "  --jitter S      driving commands come up to S seconds later\n"
      "  --unmoved       a patient who leads must not feel what breaks around server, network, disk, clock: each session twice (I12)\n"
      "  --faults LIST   one session with these faults instead of the seed's own, with its story\n"
      "  --patient NAME  who walks in each session, of hoist-sim's family; even: one whose steps are all alike (default: by the seed)\n"
      "  --story         tell what happens in each session\n"
      "  --hashes        print the hash of each second: equal on every machine, compiler and run\n"
      "  --state FILE    a run that was ended goes on where this file says; it is written again and again\n"
      "  --quiet         no line of progress\n"
      "  --jobs N        sessions at a time, from 1 (default: processors)\n",
      to);
}

int refuse(const std::string& what) {
  std::fprintf(stderr, "hoist-chaos: %s\n", what.c_str());
  usage(stderr);
  return 2;
}

bool number(const char* text, double& value) {
  char* end = nullptr;
  value = text == nullptr ? 0.0 : std::strtod(text, &end);
  return text != nullptr && end != text && *end == '\0' && value >= 0.0;
}

// The last one is the even patient.
constexpr std::size_t kPatients = hoist::sim::kPatientFamily.size() + 1;
std::string_view patient_name(std::size_t place) {
  return place + 1 == kPatients ? hoist::chaos::kEvenPatient : hoist::sim::kPatientFamily[place].name;
}
std::size_t place_of(std::string_view patient) {
  std::size_t place = 0;
  while (place + 1 < kPatients && patient_name(place) != patient) ++place;
  return place;
}

struct Totals {
  std::uint64_t done = 0, bad = 0, digest = 0, samples = 0;
  double walked_s = 0, distance_m = 0;
  std::uint64_t starts = 0, stops = 0, false_stops = 0;
  std::array<double, hoist::chaos::kModeCount> moved_s{};
  std::array<std::uint64_t, hoist::chaos::kModeCount> unasked{};
  struct Walks {
    double moved_s = 0;
    std::uint64_t unasked = 0;
  };
  std::array<Walks, kPatients> by_patient{};

  void add(const SessionReport& report) {
    ++done;
    bad += report.broken.empty() ? 0 : 1;
    digest ^= report.digest;
    samples += report.samples;
    walked_s += report.walked_s;
    distance_m += report.distance_m;
    starts += static_cast<std::uint64_t>(report.starts);
    stops += static_cast<std::uint64_t>(report.stops);
    false_stops += static_cast<std::uint64_t>(report.false_stops);
    for (std::size_t mode = 0; mode < moved_s.size(); ++mode) {
      moved_s[mode] += report.moved_s[mode];
      unasked[mode] += static_cast<std::uint64_t>(report.unasked[mode]);
      by_patient[place_of(report.patient)].unasked += static_cast<std::uint64_t>(report.unasked[mode]);
    }
    by_patient[place_of(report.patient)].moved_s += report.walked_s;
  }
};

// The run of a file, so that files of different runs are never added up.
std::string run_name(const SessionOptions& options, bool unmoved, std::uint64_t seed) {
  char text[200];
  std::snprintf(text, sizeof text, "seed=%llu length=%g faults=%d loss=%g jitter=%g unmoved=%d patient=%s",
                static_cast<unsigned long long>(seed), options.length_s, options.faults_max, options.frame_loss, options.link_jitter_s,
                unmoved ? 1 : 0, options.patient ? options.patient->c_str() : "seed");
  return text;
}
bool load(const std::string& file, const std::string& name, Totals& totals) {
  std::ifstream in(file);
  if (!in) return true;
  std::string known;
  std::getline(in, known);
  Totals t;
  in >> t.done >> t.bad >> t.digest >> t.samples >> t.walked_s >> t.distance_m >> t.starts >> t.stops >> t.false_stops;
  for (std::size_t mode = 0; mode < t.moved_s.size(); ++mode) in >> t.moved_s[mode] >> t.unasked[mode];
  for (Totals::Walks& walks : t.by_patient) in >> walks.moved_s >> walks.unasked;
  if (!in || known != name) return false;
  totals = t;
  return true;
}
void save(const std::string& file, const std::string& name, const Totals& t) {
  const std::string fresh = file + ".new";
  {
    std::ofstream out(fresh);
    out.precision(17);
    out << name << '\n'
        << t.done << ' ' << t.bad << ' ' << t.digest << ' ' << t.samples << ' ' << t.walked_s << ' ' << t.distance_m << ' ' << t.starts
        << ' ' << t.stops << ' ' << t.false_stops;
    for (std::size_t mode = 0; mode < t.moved_s.size(); ++mode) out << ' ' << t.moved_s[mode] << ' ' << t.unasked[mode];
    for (const Totals::Walks& walks : t.by_patient) out << ' ' << walks.moved_s << ' ' << walks.unasked;
    out << '\n';
  }
  (void)std::rename(fresh.c_str(), file.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  SessionOptions options;
  double sessions = 200, seed = 1, jobs = std::max(1U, std::thread::hardware_concurrency());
  bool unmoved = false, hashes = false, quiet = false;
  std::string state;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const char* next = i + 1 < argc ? argv[i + 1] : nullptr;
    if (word == "--help" || word == "-h") {
      usage(stdout);
      return 0;
    }
    if (word == "--no-faults") {
      options.faults_max = 0;
    } else if (word == "--story") {
      options.tell = true;
    } else if (word == "--unmoved") {
      unmoved = true;
    } else if (word == "--hashes") {
      hashes = true;
    } else if (word == "--quiet") {
      quiet = true;
    } else if (word == "--state" && next != nullptr) {
      state = argv[++i];
    } else if (word == "--patient" && next != nullptr) {
      options.patient = argv[++i];
      if (*options.patient != hoist::chaos::kEvenPatient && hoist::sim::find_patient(*options.patient) == nullptr)
        return refuse("--patient: there is no " + *options.patient);
    } else if (word == "--faults" && next != nullptr) {
      options.faults = hoist::chaos::read_faults(argv[++i]);
      if (!options.faults) return refuse("--faults: kind:node:start:end:size, with commas in between, not " + std::string(argv[i]));
      options.tell = true;
      sessions = 1;
    } else if (word == "--sessions" || word == "--seed" || word == "--jobs" || word == "--length" || word == "--loss" ||
               word == "--jitter") {
      double& value = word == "--sessions" ? sessions
                      : word == "--seed"   ? seed
                      : word == "--jobs"   ? jobs
                      : word == "--length" ? options.length_s
                      : word == "--loss"   ? options.frame_loss
                                           : options.link_jitter_s;
      if (!number(next, value)) return refuse(word + " needs a number that is not negative");
      ++i;
    } else {
      return refuse("there is no option " + word + ", or it lacks its value");
    }
  }
  if (sessions < 1) return refuse("--sessions: at least 1");
  if (jobs < 1) return refuse("--jobs: at least 1");
  if (options.length_s < 15) return refuse("--length: at least 15 s");
  if (options.frame_loss > 0.2) return refuse("--loss: 0 to 0.2");
  if (options.link_jitter_s > 1.0) return refuse("--jitter: 0 to 1 s");
  options.only_walk = options.outside_only = unmoved;

  const auto count = static_cast<std::uint64_t>(sessions), first = static_cast<std::uint64_t>(seed);
  const std::string name = run_name(options, unmoved, first);
  Totals totals;
  if (!state.empty() && !load(state, name, totals)) {
    std::fprintf(stderr, "%s belongs to another run; remove it or name another file.\n", state.c_str());
    return 2;
  }
  std::uint64_t shrunk = 0;
  std::mutex mutex;
  const auto began = std::chrono::steady_clock::now();
  const std::uint64_t done_before = totals.done;
  while (totals.done < count) {
    const std::uint64_t from = totals.done,
                        to = std::min(count, from + kPiece * std::max<std::uint64_t>(1, static_cast<std::uint64_t>(jobs)));
    std::atomic<std::uint64_t> next{from};
    const auto work = [&] {
      for (std::uint64_t i = next++; i < to; i = next++) {
        SessionOptions mine = options;
        mine.seed = first + i;
        const SessionReport report = unmoved ? hoist::chaos::run_unmoved(mine) : hoist::chaos::run_session(mine);
        std::string smaller;
        {
          const std::lock_guard lock(mutex);
          totals.add(report);
          for (const std::string& line : report.story) std::puts(line.c_str());
          if (hashes)
            for (std::size_t s = 0; s < report.hashes.size(); ++s)
              std::printf("seed %llu second %zu %016llx\n", static_cast<unsigned long long>(report.seed), s + 1,
                          static_cast<unsigned long long>(report.hashes[s]));
          if (report.broken.empty()) continue;
          for (const std::string& line : report.broken)
            std::printf("seed %llu: %s\n", static_cast<unsigned long long>(report.seed), line.c_str());
          if (options.faults || ++shrunk > kShrunkMost) continue;
        }
        smaller = hoist::chaos::replay_words(hoist::chaos::shrink(mine, report));
        const std::lock_guard lock(mutex);
        std::printf("seed %llu, at its smallest: deploy/dev chaos %s\n", static_cast<unsigned long long>(report.seed), smaller.c_str());
        std::fflush(stdout);
      }
    };
    std::vector<std::thread> threads;
    for (int i = 1; i < static_cast<int>(jobs); ++i) threads.emplace_back(work);
    work();
    for (std::thread& thread : threads) thread.join();
    if (!state.empty()) save(state, name, totals);
    const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    const double per_s = static_cast<double>(totals.done - done_before) / std::max(took_s, 1e-3);
    if (!quiet && count > 2 * kPiece)
      std::fprintf(stderr, "%llu of %llu sessions, %.1f a second, %.0f min to go, %llu failed, %llu false stops\n",
                   static_cast<unsigned long long>(totals.done), static_cast<unsigned long long>(count), per_s,
                   static_cast<double>(count - totals.done) / std::max(per_s, 1e-3) / 60.0, static_cast<unsigned long long>(totals.bad),
                   static_cast<unsigned long long>(totals.false_stops));
  }
  std::printf(
      "%llu sessions of %g s: %llu starts, %.1f h in motion, %.1f km, %llu protective stops, %llu false stops, %llu samples found again; "
      "digest %016llx\n",
      static_cast<unsigned long long>(totals.done), options.length_s, static_cast<unsigned long long>(totals.starts),
      totals.walked_s / 3600, totals.distance_m / 1000, static_cast<unsigned long long>(totals.stops),
      static_cast<unsigned long long>(totals.false_stops), static_cast<unsigned long long>(totals.samples),
      static_cast<unsigned long long>(totals.digest));
  for (std::size_t mode = 0; mode < totals.moved_s.size(); ++mode) {
    if (totals.moved_s[mode] <= 0) continue;
    const double hours = totals.moved_s[mode] / 3600;
    std::printf("%-7s %7.2f h in motion, %llu unasked stops, %.2f an hour\n", std::string(hoist::contract::kModes[mode].name).c_str(),
                hours, static_cast<unsigned long long>(totals.unasked[mode]), static_cast<double>(totals.unasked[mode]) / hours);
  }
  for (std::size_t place = 0; place < kPatients; ++place) {
    const Totals::Walks& walks = totals.by_patient[place];
    if (walks.moved_s <= 0) continue;
    const double hours = walks.moved_s / 3600;
    std::printf("%-10s %7.2f h in motion, %llu unasked stops, %.2f an hour\n", std::string(patient_name(place)).c_str(), hours,
                static_cast<unsigned long long>(walks.unasked), static_cast<double>(walks.unasked) / hours);
  }
  std::printf("%llu passed, %llu failed, 0 skipped\n", static_cast<unsigned long long>(totals.done - totals.bad),
              static_cast<unsigned long long>(totals.bad));
  return totals.bad == 0 ? 0 : 1;
}
