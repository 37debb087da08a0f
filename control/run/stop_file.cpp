#include "control/run/stop_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "control/contract/check.hpp"
#include "control/contract/faults.hpp"

namespace hoist::run {
namespace {
using nlohmann::json;

constexpr std::uintmax_t kFileBytesMax = 1 << 16;  // our own file has at most 3 kB

// Over all that is told, so that a hand-edited or half-written file is noticed. Not a defence against malice.
std::string checksum(const json& values) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(contract::hash_bytes(contract::kHashStart, values.dump())));
  return text;
}

json fault_names(std::uint64_t bits) {
  json names = json::array();
  for (const contract::FaultInfo& fault : contract::kFaults)
    if ((bits >> fault.bit & 1U) != 0) names.push_back(fault.name);
  return names;
}

/// False when the values are not what save_stop_file writes.
bool read_values(const json& values, bool same_boot, std::int64_t now_ns, core::StopHistory& history) {
  if (!values.contains("stops") || !values["stops"].is_array() || values["stops"].size() > history.stops.size()) return false;
  for (const json& item : values["stops"]) {
    if (!item.is_object() || !item.contains("fault") || !item["fault"].is_string() || !item.contains("time_ns") ||
        !item["time_ns"].is_number_integer())
      return false;
    const contract::FaultInfo* fault = contract::find_fault(item["fault"].get<std::string>());
    if (fault == nullptr) continue;  // of another version, which knew other faults
    const auto time_ns = item["time_ns"].get<std::int64_t>();
    history.stops[history.count++] = {same_boot ? std::min(time_ns, now_ns) : now_ns, fault->bit};
  }
  if (!values.contains("out_of_service") || !values["out_of_service"].is_array()) return false;
  for (const json& name : values["out_of_service"]) {
    if (!name.is_string()) return false;
    const contract::FaultInfo* fault = contract::find_fault(name.get<std::string>());
    if (fault != nullptr) history.out_of_service |= 1ULL << fault->bit;
  }
  return true;
}

/// True when all of it is on the disk.
bool write_durably(const std::string& path, const std::string& text) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return false;
  const bool written = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && ::fsync(fd) == 0;
  return ::close(fd) == 0 && written;
}

bool sync_folder_of(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const int fd = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool synced = ::fsync(fd) == 0;
  return ::close(fd) == 0 && synced;
}
}  // namespace

LoadedStops load_stop_file(const std::string& path, const std::string& boot_id, std::uint64_t now_ns) {
  LoadedStops loaded;
  const auto refuse = [&](const char* why) {
    loaded.history = {};
    loaded.history.out_of_service = contract::fault_bit(contract::Fault::control_fault);
    loaded.problem = path + " " + why;
    return loaded;
  };
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (error == std::errc::no_such_file_or_directory) return loaded;
  if (error || bytes > kFileBytesMax) return refuse("is not a stop file");
  std::ifstream file(path);
  const json document = json::parse(file, nullptr, false);
  if (!document.is_object() || !document.contains("values") || !document["values"].is_object() || !document.contains("checksum"))
    return refuse("is not a stop file");
  const json& values = document["values"];
  if (document["checksum"] != checksum(values)) return refuse("was damaged or edited by hand (checksum)");
  const bool same_boot = !boot_id.empty() && values.contains("boot_id") && values["boot_id"] == boot_id;
  if (!read_values(values, same_boot, static_cast<std::int64_t>(now_ns), loaded.history)) return refuse("is not a stop file");
  return loaded;
}

std::string save_stop_file(const std::string& path, const std::string& boot_id, const core::StopHistory& history) {
  json stops = json::array();
  for (std::size_t i = 0; i < std::min<std::size_t>(history.count, history.stops.size()); ++i) {
    const core::StopHistory::Stop& stop = history.stops[i];
    stops.push_back({{"fault", contract::fault_info(static_cast<contract::Fault>(stop.fault)).name}, {"time_ns", stop.time_ns}});
  }
  const json values = {{"boot_id", boot_id}, {"stops", std::move(stops)}, {"out_of_service", fault_names(history.out_of_service)}};
  const std::string text = json{{"product", "hoist"}, {"checksum", checksum(values)}, {"values", values}}.dump(1) + "\n";
  const std::string fresh = path + ".new";
  const auto fail = [](const char* what, const std::string& which) {
    return std::string(what) + " " + which + ": " + std::strerror(errno);
  };
  if (!write_durably(fresh, text)) return fail("cannot write", fresh);
  if (::rename(fresh.c_str(), path.c_str()) != 0) return fail("cannot put in place", fresh);
  if (!sync_folder_of(path)) return fail("cannot sync the folder of", path);
  return {};
}

std::string boot_id() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(file, id);
  return id;
}

}  // namespace hoist::run
