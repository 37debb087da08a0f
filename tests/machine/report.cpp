// machine-report: what the firmware costs, measured on the models of its chips, as a Markdown table on standard output. The same
// images and programs give the same table.
//   machine-report [SECONDS]    how long the hoist walks the figure of eight for it (20)
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/machine/hoist_bench.hpp"
#include "tests/machine/lockstep_core.hpp"

namespace hoist::machine {
namespace {

constexpr double kBudget_cycles = 48'000;  // one millisecond at 48 MHz
constexpr std::uint32_t kTicks = 20'000;

struct Cost {
  std::uint64_t worst{}, total{}, instructions{}, worst_instructions{};
  std::uint32_t stack{};
};
std::optional<Cost> measure(const std::string& program) {
  const auto image = load_elf(std::string(HOIST_PROGRAMS_DIR) + "/" + program + ".elf", kFlashBytes);
  if (!image) return std::nullopt;
  LockstepCore core(*image);
  Cost cost;
  for (std::uint32_t tick = 0; tick < kTicks; ++tick) {
    if (!core.tick()) return std::nullopt;
    cost.worst = std::max(cost.worst, core.cycles());
    cost.total += core.cycles();
    cost.instructions += core.instructions();
    cost.worst_instructions = std::max(cost.worst_instructions, core.instructions());
  }
  cost.stack = core.stack_bytes();
  return cost;
}

std::uint32_t symbol(const Image& image, const std::string& name) {
  const auto at = image.symbols.find(name);
  return at == image.symbols.end() ? 0 : at->second;
}

bool walk(const Images& images, ImageChip kind, double seconds) {
  BenchOptions options;
  options.scenario = sim::find_scenario("figure-eight");
  options.chips.fill(kind);
  MachineLoop loop(images, options);
  if (!loop.start(contract::Mode::user)) {
    std::fprintf(stderr, "machine-report: the hoist does not start: %s\n", loop.faults().c_str());
    return false;
  }
  for (std::size_t i = 0; i < kBoxCount; ++i) loop.bench().chip(static_cast<Box>(i)).core().reset_work();
  loop.run(seconds);
  std::printf(
      "\n### %s\n\n"
      "| board | instructions per ms | clocks per ms, no waits, mean / worst | all waits, mean / worst | share of the processor "
      "| stack used / there, bytes |\n"
      "|---|---|---|---|---|---|\n",
      kind == ImageChip::stm32f072 ? "STM32F072" : "LPC11C24");
  for (std::size_t i = 0; i < kBoxCount; ++i) {
    const Chip& chip = loop.bench().chip(static_cast<Box>(i));
    const CortexM0::Work& work = chip.core().work();
    const Image& image = images.of(kind, static_cast<Box>(i));
    const std::uint32_t top = symbol(image, "hoist_stack_top"), low = symbol(image, "hoist_stack_low");
    const auto ticks = static_cast<double>(std::max<std::uint64_t>(work.ticks, 1));
    std::printf("| %s | %.0f | %.0f / %llu | %.0f / %llu | %.1f to %.1f %% | %u / %u |\n", chip.name().c_str(),
                static_cast<double>(work.instructions) / ticks, static_cast<double>(work.total_without_waits) / ticks,
                static_cast<unsigned long long>(work.worst_without_waits), static_cast<double>(work.total_cycles) / ticks,
                static_cast<unsigned long long>(work.worst_cycles),
                100.0 * static_cast<double>(work.total_without_waits) / ticks / kBudget_cycles,
                100.0 * static_cast<double>(work.total_cycles) / ticks / kBudget_cycles, top - chip.core().lowest_sp(), top - low);
  }
  const CanWire& wire = loop.bench().wire();
  std::printf("\nBus load with the frames' own stuff bits: %.1f %%. Violations found by the model: %s.\n",
              100.0 * static_cast<double>(wire.busy_time()) / static_cast<double>(loop.bench().now()),
              loop.bench().violations().empty() ? "none" : loop.bench().violations().c_str());
  return true;
}

int report(double seconds) {
  std::printf(
      "<!-- Made by `deploy/dev firmware`; do not edit. -->\n\n# What the firmware costs on its chips\n\n"
      "The images as they are flashed, run on models of the chips (tests/machine) at 48 MHz. Never measured on\n"
      "silicon. Clocks are the Cortex-M0's (fast multiplier); *no waits* supposes a flash that always keeps up, *all waits* charges each "
      "32-bit\n"
      "word fetched from it with the flash's wait states (LPC11C24 two, STM32F072 one), as if nothing were fetched ahead: the truth lies "
      "between. A millisecond has 48000 "
      "clocks;\n"
      "the servo tick may take 12000.\n\n"
      "## One tick of a node, without interrupts and flash waits\n\n"
      "20000 ticks with changing speeds (drive) and swaying (tilt; its work comes with every tenth tick).\n\n"
      "| node | instructions, mean / worst | clocks, mean / worst | share of a millisecond, worst | stack, bytes |\n"
      "|---|---|---|---|---|\n");
  for (const char* name : {"drive", "tilt"}) {
    const auto cost = measure(std::string("lockstep_") + name);
    if (!cost) {
      std::fprintf(stderr, "machine-report: the programs are missing or do not run\n");
      return 1;
    }
    std::printf("| %s | %.0f / %llu | %.0f / %llu | %.1f %% | %u |\n", name, static_cast<double>(cost->instructions) / kTicks,
                static_cast<unsigned long long>(cost->worst_instructions), static_cast<double>(cost->total) / kTicks,
                static_cast<unsigned long long>(cost->worst), 100.0 * static_cast<double>(cost->worst) / kBudget_cycles, cost->stack);
  }

  const ImagesOrReason found = load_images();
  if (!found.images) {
    std::fprintf(stderr, "machine-report: %s\n", found.reason.c_str());
    return 1;
  }
  std::printf(
      "\n## All work of a millisecond, walking the figure of eight\n\n"
      "Interrupts, main loop and bus included, with the real control core behind the gateway. Stack: the deepest since power-on, of all "
      "the\n"
      "RAM that is left for it.\n");
  return walk(*found.images, ImageChip::lpc11c24, seconds) && walk(*found.images, ImageChip::stm32f072, seconds) ? 0 : 1;
}

}  // namespace
}  // namespace hoist::machine

int main(int count, char** arguments) {
  const double seconds = count > 1 ? std::atof(arguments[1]) : 20.0;
  return hoist::machine::report(seconds > 0.0 && seconds < 1000.0 ? seconds : 20.0);
}
