// The recorder's reading of the journal. All that is new is taken over at each look; what belongs to the open session goes to its writer as far
// as its ticks have come, the rest waits here, because a session may begin and end with any step.
#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "control/publish/server_link.hpp"
#include "db/store/session_writer.hpp"

namespace hoist::server {

class JournalFeed {
 public:
  // From the oldest that the core still holds: a session may begin there.
  explicit JournalFeed(const publish::ServerLink& link)
      : steps_(link, publish::ReadFrom::oldest), commands_(link, publish::ReadFrom::oldest), images_(link, publish::ReadFrom::oldest) {}

  /// Takes over what is new; keeps at most as much as the core itself holds.
  void read() {
    // Commands and images are published before their step: the step, once seen, has all of its own here.
    take(steps_, step_buffer_, kept_steps_, contract::kJournalSlots);
    take(commands_, command_buffer_, kept_commands_, contract::kJournalCommandSlots);
    take(images_, image_buffer_, kept_images_, contract::kImageSlots);
  }

  /// The steps of this life of the core from first_tick to last_tick go to the writer; what is older, or of an earlier life, is dropped.
  db::Status give(db::SessionWriter& writer, std::uint64_t life, std::uint64_t first_tick, std::uint64_t last_tick) {
    give_.clear();
    give_commands_.clear();
    while (!kept_steps_.empty() && is_due(kept_steps_.front(), life, last_tick)) {
      const auto& [of, step] = kept_steps_.front();
      if (of == life && step.tick >= first_tick) give_.push_back(step);
      kept_steps_.pop_front();
    }
    if (give_.empty()) return {};
    while (!kept_commands_.empty() && (kept_commands_.front().life < life ||
                                       (kept_commands_.front().life == life && kept_commands_.front().value.step <= give_.back().step))) {
      if (kept_commands_.front().life == life) give_commands_.push_back(kept_commands_.front().value);
      kept_commands_.pop_front();
    }
    db::Status given = writer.append_journal(give_, give_commands_);
    while (!kept_images_.empty() && is_due(kept_images_.front(), life, last_tick)) {
      const auto& [of, image] = kept_images_.front();
      if (given.ok() && of == life && image.tick >= first_tick) given = writer.append_image(image);
      kept_images_.pop_front();
    }
    return given;
  }

  /// The newest image of this life of the core at or before a step's tick, and the time of the step it stands before.
  struct Beginning {
    std::uint64_t tick = 0, time_ns = 0;
  };
  [[nodiscard]] std::optional<Beginning> image_before(std::uint64_t life, std::uint64_t tick) const {
    std::optional<Beginning> found;
    for (const auto& [of, image] : kept_images_)
      if (of == life && image.tick <= tick)
        for (const auto& [its, step] : kept_steps_)
          if (its == life && step.step == image.step) found = {image.tick, step.time_ns};
    return found;
  }

 private:
  template <typename T>
  struct Kept {
    std::uint64_t life = 0;
    T value;
  };
  template <typename T>
  static bool is_due(const Kept<T>& kept, std::uint64_t life, std::uint64_t last_tick) {
    return kept.life < life || (kept.life == life && kept.value.tick <= last_tick);
  }
  template <typename Reader, typename T>
  static void take(Reader& reader, std::vector<T>& buffer, std::deque<Kept<T>>& kept, std::size_t most) {
    for (auto got = reader.read(buffer); got.count > 0; got = reader.read(buffer))
      for (std::size_t i = 0; i < got.count; ++i) {
        if (kept.size() == most) kept.pop_front();
        kept.push_back({reader.life(), buffer[i]});
      }
  }

  publish::JournalReader steps_;
  publish::JournalCommandReader commands_;
  publish::ImageReader images_;
  std::vector<contract::JournalStep> step_buffer_{64}, give_;
  std::vector<contract::JournalCommand> command_buffer_{64}, give_commands_;
  std::vector<contract::CoreImage> image_buffer_{1};
  std::deque<Kept<contract::JournalStep>> kept_steps_;
  std::deque<Kept<contract::JournalCommand>> kept_commands_;
  std::deque<Kept<contract::CoreImage>> kept_images_;
};

}  // namespace hoist::server
