// Publishes a control step: what it was given, what it gave. Used by the control loop, and by the tests that record without one.
#pragma once
#include <cstring>
#include <span>

#include "control/contract/faults.hpp"
#include "control/publish/core_link.hpp"
#include "control/publish/journal.hpp"

namespace hoist::publish {

/// Steps between two images of the core.
inline constexpr std::uint64_t kImageSteps = 100;

/// One core's life: begin with another core, begin with another publisher. No allocation, no system call.
class StepPublisher {
 public:
  explicit StepPublisher(CoreLink& link) noexcept : link_(link) {}

  /// Before the step. An image is due each second, and before a step that may begin a motion, so that a recording begins with one.
  void before(const core::CoreState& state, const core::TickInputs& inputs) noexcept {
    const bool may_begin = !inputs.commands.empty() && !contract::kModes[static_cast<std::size_t>(state.mode)].moving;
    if (step_ < next_image_ && !may_begin) return;
    take_image(state, step_, inputs.tick, image_);
    link_.publish_image(image_);
    next_image_ = step_ + kImageSteps;
  }

  /// After the step, of whose frames the bus took the first `sent`: one that did not leave is not in a recording. The record goes last: a
  /// reader that has it finds everything else of its step.
  void after(const core::TickInputs& inputs, const core::TickOutputs& outputs, std::size_t sent) noexcept {
    frames(inputs.frames, inputs.time_ns, 0);
    frames({outputs.frames.data(), sent}, inputs.time_ns, 1);
    for (const contract::Command& command : inputs.commands) link_.publish_journal(contract::JournalCommand{step_, command});
    link_.publish_journal(journal_of(inputs, step_++, digest_of(outputs.record)));
    for (const contract::Event& event : outputs.events) link_.publish_event(event);
    link_.publish_tick(outputs.record);
  }

 private:
  void frames(std::span<const contract::CanFrame> all, std::uint64_t time_ns, std::uint8_t sent) noexcept {
    for (const contract::CanFrame& frame : all) {
      contract::BusRecord record{time_ns, frame.id, frame.dlc, frame.flags, sent, 0, 0};
      std::memcpy(&record.data, frame.data.data(), sizeof record.data);
      link_.publish_bus(record);
    }
  }

  CoreLink& link_;
  std::uint64_t step_ = 0, next_image_ = 0;
  contract::CoreImage image_;
};

}  // namespace hoist::publish
