// What this hoist is called and speaks: settings that people change in the console; and its id, which nobody changes.
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
  std::string hoist_id;                 ///< hoist_id.hpp; empty in a backup
  std::string tag;                      ///< of name and language
};
struct DeviceSettingsPatch {
  std::optional<std::string> name;
  std::optional<std::optional<std::string>> language;
};

Result<DeviceSettings> device_settings(Database& database);
/// Name and language of another file of the same hoist. Throws SqlFailure.
void set_device_settings(sqlite3* handle, const DeviceSettings& settings);
/// `expected`: the tag of what the change was made for, empty = any. Errors: changed, bad_value (device_name), busy, disk_full.
Result<DeviceSettings> change_device_settings(Database& database, const DeviceSettingsPatch& patch, const std::string& expected);

}  // namespace hoist::db
