#include "db/store/device_settings.hpp"

#include "db/store/hoist_id.hpp"
#include "db/store/session_checks.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

constexpr const char *kName = "device_name", *kLanguage = "language";

DeviceSettings read(sqlite3* handle) {
  DeviceSettings settings;
  Statement row(handle, "SELECT name, value FROM settings WHERE name IN (?1, ?2)");
  row.text(1, std::string_view(kName)).text(2, std::string_view(kLanguage));
  while (row.step()) {
    if (row.text_at(0) == kName)
      settings.name = row.text_at(1);
    else
      settings.language = row.text_at(1);
  }
  settings.hoist_id = hoist_id(handle);
  settings.tag = edit_tag({settings.name, settings.language.value_or("")});
  return settings;
}

// Inside a write transaction; without a value the row goes.
void store(sqlite3* handle, const char* name, const std::optional<std::string>& value) {
  if (value)
    Statement(handle, "INSERT OR REPLACE INTO settings (name, value) VALUES (?1, ?2)").text(1, std::string_view(name)).text(2, value).run();
  else
    Statement(handle, "DELETE FROM settings WHERE name = ?1").text(1, std::string_view(name)).run();
}

}  // namespace

Result<DeviceSettings> device_settings(Database& database) {
  return guarded([&]() -> Result<DeviceSettings> { return read(database.handle()); });
}

void set_device_settings(sqlite3* handle, const DeviceSettings& settings) {
  store(handle, kName, settings.name.empty() ? std::nullopt : std::optional(settings.name));
  store(handle, kLanguage, settings.language);
}

Result<DeviceSettings> change_device_settings(Database& database, const DeviceSettingsPatch& patch, const std::string& expected) {
  if (patch.name && !is_plain_line(*patch.name, kMaxDeviceName_bytes))
    return Error{ErrorKind::bad_value, "must be one line of at most 64 bytes", kName};
  return guarded([&]() -> Result<DeviceSettings> {
    sqlite3* handle = database.handle();
    Transaction transaction(handle, Transaction::Kind::write);
    if (const Status same = check_tag(expected, read(handle).tag); !same) return same.error();
    if (patch.name) store(handle, kName, patch.name->empty() ? std::nullopt : patch.name);
    if (patch.language) store(handle, kLanguage, *patch.language);
    DeviceSettings after = read(handle);
    transaction.commit();
    return after;
  });
}

}  // namespace hoist::db
