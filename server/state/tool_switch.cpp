#include "server/state/tool_switch.hpp"

#include <fstream>

namespace hoist::server {

namespace {
constexpr const char* kOn = "on";
}

ToolSwitch::ToolSwitch(std::filesystem::path file, bool forced) : file_(std::move(file)), on_(forced) {
  std::string word;
  if (std::ifstream(file_) >> word && word == kOn) on_ = true;
}

bool ToolSwitch::store(const std::filesystem::path& file, bool on) {
  std::error_code error;
  const std::filesystem::path fresh = file.string() + ".new";
  {
    std::ofstream out(fresh, std::ios::trunc);
    out << (on ? kOn : "off") << '\n';
    if (!out.flush()) return false;
  }
  using std::filesystem::perms;
  std::filesystem::permissions(fresh, perms::owner_read | perms::owner_write, error);
  if (!error) std::filesystem::rename(fresh, file, error);
  return !error;
}

}  // namespace hoist::server
