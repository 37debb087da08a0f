#include "control/run/parameter_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

namespace hoist::run {
namespace {
using nlohmann::json;

// Over names and values, so that a hand-edited or half-written file is noticed. Not a defence against malice.
std::string checksum(const json& values) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(contract::hash_bytes(contract::kHashStart, values.dump())));
  return text;
}
constexpr off_t kFileBytesMax = 1 << 20;  // our own file has about 2 kB; anything near this is not ours
}  // namespace

LoadedParams load_parameter_file(const std::string& path) {
  LoadedParams loaded;
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    loaded.usable = errno == ENOENT;
    if (!loaded.usable) loaded.problem = "cannot read " + path + ": " + std::strerror(errno);
    return loaded;
  }
  if (status.st_size > kFileBytesMax) {
    loaded.problem = path + " is too large to be a parameter file";
    return loaded;
  }
  std::ifstream file(path);
  const json document = json::parse(file, nullptr, false);
  if (!document.is_object() || !document.contains("values") || !document["values"].is_object() || !document.contains("checksum")) {
    loaded.problem = path + " is not a parameter file";
    return loaded;
  }
  const json& values = document["values"];
  if (document["checksum"] != checksum(values)) {
    loaded.problem = path + " was damaged or edited by hand (checksum)";
    return loaded;
  }
  for (const auto& [name, value] : values.items()) {
    const auto index = contract::find_param(name);
    if (!index) {
      loaded.remarks.push_back("stored parameter " + name + " is unknown to this version and was left out");
      continue;
    }
    const double number = value.is_number() ? value.get<double>() : 0.0;
    if (!value.is_number() || contract::check_param(*index, number) != contract::ParamCheck::ok) {
      loaded.remarks.push_back("stored parameter " + name + " is outside its range and stays at its default");
      continue;
    }
    contract::set_param_unchecked(loaded.params, *index, number);
  }
  if (const char* conflict = contract::check_param_set(loaded.params)) {
    loaded.problem = path + ": " + conflict;
    loaded.params = contract::Params{};
    return loaded;
  }
  loaded.usable = true;
  return loaded;
}

std::optional<contract::Params> params_to_store(const contract::ParamsInForce& in_force, const contract::ParamsInForce& before,
                                                const contract::Params& started_with, const contract::Params& stored) {
  if (in_force.defaults_after_damage != 0 || in_force.kept == before.kept) return std::nullopt;
  contract::Params to_store = stored;
  for (std::size_t i = 0; i < contract::kParamCount; ++i) {
    const double started = contract::get_param(started_with, i);
    const bool only_this_run = in_force.kept[i] == started && started != contract::get_param(stored, i);
    if (!only_this_run) contract::set_param_unchecked(to_store, i, in_force.kept[i]);
  }
  return to_store;
}

std::string save_parameter_file(const std::string& path, const contract::Params& params) {
  json values = json::object();
  for (std::size_t i = 0; i < contract::kParamCount; ++i) values[std::string(contract::kParams[i].name)] = contract::get_param(params, i);
  const json document = {{"product", "hoist"}, {"checksum", checksum(values)}, {"values", values}};
  const std::string text = document.dump(1) + "\n";
  const std::string fresh = path + ".new";
  const auto fail = [&](const char* what) { return std::string(what) + " " + fresh + ": " + std::strerror(errno); };
  const int fd = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return fail("cannot create");
  const bool written = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && ::fsync(fd) == 0;
  if (::close(fd) != 0 || !written) return fail("cannot write");
  if (::rename(fresh.c_str(), path.c_str()) != 0) return fail("cannot put in place");
  return {};
}

}  // namespace hoist::run
