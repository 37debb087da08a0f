// Whether programs such as Foxglove Studio and ROS pages may connect. Off until an engineer switches it on; kept in a small file beside the database.
#pragma once
#include <filesystem>
#include <string>
#include <utility>

namespace hoist::server {

class ToolSwitch {
 public:
  // `forced`: on for this run, whatever is stored. A file that cannot be read means off.
  ToolSwitch(std::filesystem::path file, bool forced);

  [[nodiscard]] bool on() const { return on_; }
  void set(bool on) { on_ = on; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  // On any thread that may wait for the disk. False: not stored.
  [[nodiscard]] static bool store(const std::filesystem::path& file, bool on);

 private:
  std::filesystem::path file_;
  bool on_ = false;
};

}  // namespace hoist::server
