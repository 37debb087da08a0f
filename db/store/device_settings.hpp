// What this hoist is called and speaks: settings that people change in the console.
#pragma once
#include <optional>
#include <string>

#include "db/store/database.hpp"
#include "db/store/edit_tag.hpp"
#include "db/store/result.hpp"

namespace hoist::db {

inline constexpr std::size_t kMaxDeviceName_bytes = 64;

struct DeviceSettings {
  std::string name;                     ///< one line; empty: the computer's own name
  std::optional<std::string> language;  ///< en, de; absent: as each browser asks
  std::string tag;
};
struct DeviceSettingsPatch {
  std::optional<std::string> name;
  std::optional<std::optional<std::string>> language;
};

Result<DeviceSettings> device_settings(Database& database);
/// `expected`: the tag of what the change was made for, empty = any. Errors: changed, bad_value (device_name), busy, disk_full.
Result<DeviceSettings> change_device_settings(Database& database, const DeviceSettingsPatch& patch, const std::string& expected);

}  // namespace hoist::db
