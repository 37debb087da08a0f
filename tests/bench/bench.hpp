// The sections of hoist-bench.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tests/bench/table.hpp"

namespace hoist::bench {

// Nanoseconds per call: the median of several rounds, each long enough to read the clock.
double nanoseconds_per_call(const std::function<void(int)>& calls);

void measure_law_and_tick(Report& report);
void measure_shared_memory(Report& report);
void measure_simulator(Report& report);
void measure_recording(Report& report);
void measure_rerun(Report& report);
void measure_console(Report& report);
void measure_firmware(Report& report);
// These start the real programs from the folder `bin`.
void measure_loop(Report& report, const std::string& bin);
void measure_websocket(Report& report, const std::string& bin);
void measure_driving(Report& report, const std::string& bin);
void measure_rest(Report& report, const std::string& bin);
void measure_export(Report& report, const std::string& bin);
void measure_served(Report& report, const std::string& bin);
void measure_instructions(Report& report, const std::string& bin);
void measure_status_instructions(Report& report, const std::string& bin);

// Modes of hoist-bench under callgrind: `hoist-bench --replay-ticks COUNT` runs the ticks of a recorded walk, `--replay-steps COUNT` the
// whole steps of hoist-control around them, without the kernel.
inline constexpr const char *kReplayTicks = "--replay-ticks", *kReplaySteps = "--replay-steps";
void replay_ticks(int count);
void replay_steps(int count);

// A walk of this length with its received frames, recorded in a new database as its only session.
void record_walk(const std::string& database, double seconds);

}  // namespace hoist::bench
