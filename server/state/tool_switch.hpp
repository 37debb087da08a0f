// Whether programs such as Foxglove Studio and ROS pages may connect. Off until an engineer switches it on; kept in a small file beside the database.
#pragma once
#include <filesystem>
#include <string>
#include <utility>

#include "db/store/edit_tag.hpp"

namespace hoist::server {

class ToolSwitch {
 public:
  // `forced`: on for this run, whatever is stored. A file that cannot be read means off.
  ToolSwitch(std::filesystem::path file, bool forced);

  [[nodiscard]] bool on() const { return on_; }
  // For If-Match.
  [[nodiscard]] std::string tag() const { return db::edit_tag({on_ ? "on" : "off"}); }
  void set(bool on) { on_ = on; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  // On any thread that may wait for the disk. False: not stored.
  [[nodiscard]] static bool store(const std::filesystem::path& file, bool on);

 private:
  std::filesystem::path file_;
  bool on_ = false;
};

}  // namespace hoist::server
