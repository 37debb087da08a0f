// What does not depend on the machine's load: instructions under callgrind, sizes of files, cycles from the model of the chips.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"

namespace hoist::bench {
namespace {
constexpr double kImageFlash_bytes = (28 - 4) * 1024;  // SIZES.gen.md counts images without the loader of 4 KiB
constexpr int kFewTicks = 2000, kManyTicks = 4000;
namespace files = std::filesystem;

// Instructions of a whole run of this program that replays `count` ticks or steps.
double instructions_of(const std::string& bin, const char* replay, int count) {
  const TemporaryFolder folder;
  std::vector<std::string> command = under_callgrind(folder.file("counts"));
  command.insert(command.end(), {bin + "/hoist-bench", replay, std::to_string(count)});
  Process run(command, folder.file("log"));
  if (run.wait() != 0) throw std::runtime_error("callgrind: " + read_text(folder.file("log")).substr(0, 300));
  return instructions_in(folder.file("counts"));
}
double instructions_each(const std::string& bin, const char* replay) {
  return (instructions_of(bin, replay, kManyTicks) - instructions_of(bin, replay, kFewTicks)) / (kManyTicks - kFewTicks);
}

double gzip_bytes(const files::path& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen(("gzip -9 -c '" + file.string() + "' | wc -c").c_str(), "r"),
                                                             ::pclose);
  double bytes = 0;
  if (pipe == nullptr || std::fscanf(pipe.get(), "%lf", &bytes) != 1) throw std::runtime_error("gzip failed on " + file.string());
  return bytes;
}

// The cells of the first table row that begins with `name`, after the heading `below`.
std::vector<std::string> table_row(const files::path& page, const std::string& below, const std::string& name) {
  std::ifstream file(page);
  bool found = below.empty();
  for (std::string line; std::getline(file, line);) {
    found = found || line == below;
    if (!found || !line.starts_with("| " + name + " |")) continue;
    std::vector<std::string> cells;
    std::istringstream words(line.substr(2));
    for (std::string cell; std::getline(words, cell, '|');) cells.push_back(cell);
    return cells;
  }
  throw std::runtime_error(page.string() + " has no row " + name);
}
// The number behind the last '/' of a cell, or the cell's only number.
double last_number(const std::string& cell) { return std::stod(cell.substr(cell.find('/') == std::string::npos ? 0 : cell.find('/') + 1)); }
}  // namespace

void measure_instructions(Report& report, const std::string& bin) {
  Row tick{"instructions.tick", "instructions of a tick, walking", 0, "instr", 0, "", {}, true, "callgrind, mean of 2000 ticks"};
  Row step{"instructions.step", "instructions of a step: SLCAN, tick, shared memory", 0, "instr", 0, "its tick", {}, true};
  if (::access(kValgrind, X_OK) != 0) {
    for (const Row& row : {tick, step}) report.skip(row.id, row.what, std::string("valgrind is missing (") + kValgrind + ")");
    return;
  }
  tick.value = instructions_each(bin, kReplayTicks);
  report.add(tick);
  step.value = instructions_each(bin, kReplaySteps);
  step.floor = tick.value;
  report.add(step);
}

void measure_console(Report& report) {
  const files::path dist = files::path(HOIST_SOURCE_DIR) / "web/dist";
  const std::string index = read_text(dist / "index.html");
  const char *first_what = "first load, gzip", *more_what = "largest further script or style sheet, gzip";
  if (index.empty()) {
    report.skip("console.first", first_what, "web/dist is not built");
    report.skip("console.more", more_what, "web/dist is not built");
    return;
  }
  double first = gzip_bytes(dist / "index.html"), more = 0;
  for (const auto& asset : files::directory_iterator(dist / "assets")) {
    if (asset.path().extension() != ".js" && asset.path().extension() != ".css") continue;
    const double bytes = gzip_bytes(asset.path());
    if (index.find(asset.path().filename().string()) != std::string::npos)
      first += bytes;
    else
      more = std::max(more, bytes);
  }
  report.add({"console.first", first_what, first * 1e-3, "kB", 0, "", {70}, true});
  report.add({"console.more", more_what, more * 1e-3, "kB", 0, "", {30}, true});
}

void measure_firmware(Report& report) {
  const files::path firmware = files::path(HOIST_SOURCE_DIR) / "firmware";
  const std::string ticks = "## One tick of a node, without interrupts and flash waits";
  for (const char* node : {"drive", "tilt"}) {
    const std::vector<std::string> cells = table_row(firmware / "MACHINE.gen.md", ticks, node);
    Row row{std::string("firmware.") + node,
            std::string(node) + " node, worst tick on the LPC11C24",
            last_number(cells.at(2)),
            "clocks",
            0,
            "",
            {},
            true,
            "firmware/MACHINE.gen.md"};
    if (std::string(node) == "drive") row.goal.limit = 12000;  // the servo tick: a quarter of a millisecond at 48 MHz
    report.add(row);
  }
  for (const char* node : {"drive", "gateway", "io", "tilt"}) {
    const std::string name = node;
    const std::vector<std::string> cells = table_row(firmware / "SIZES.gen.md", "", "hoist-" + name + "-lpc11c24");
    report.add({"firmware.flash_" + name,
                name + " node, flash on the LPC11C24",
                last_number(cells.at(1)),
                "B",
                0,
                "",
                {kImageFlash_bytes},
                true,
                "28 KiB with the loader"});
    report.add({"firmware.ram_" + name,
                name + " node, RAM on the LPC11C24",
                last_number(cells.at(3)),
                "B",
                0,
                "",
                {6 * 1024},
                true,
                "firmware/SIZES.gen.md"});
  }
}

}  // namespace hoist::bench
