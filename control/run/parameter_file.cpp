#include "control/run/parameter_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

namespace hoist::run {
namespace {
using nlohmann::json;

// Over names and values, so that a hand-edited or half-written file is noticed. Not a defence against malice.
std::string checksum(const json& values) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(contract::hash_bytes(contract::kHashStart, values.dump())));
  return text;
}

// 0, or the error.
int sync_folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return errno;
  const int error = ::fsync(fd) == 0 ? 0 : errno;
  ::close(fd);
  return error;
}

int write_synced(int fd, const std::string& text) {
  const ssize_t written = ::write(fd, text.data(), text.size());
  if (written < 0) return errno;
  // A disk that fills up takes a part and reports no error.
  if (written != static_cast<ssize_t>(text.size())) return ENOSPC;
  return ::fsync(fd) == 0 ? 0 : errno;
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

Saved save_parameter_file(const std::string& path, const contract::Params& params) {
  json values = json::object();
  for (std::size_t i = 0; i < contract::kParamCount; ++i) values[std::string(contract::kParams[i].name)] = contract::get_param(params, i);
  const json document = {{"product", "hoist"}, {"checksum", checksum(values)}, {"values", values}};
  const std::string text = document.dump(1) + "\n";
  const std::string fresh = path + ".new";
  const auto failed = [&fresh](const char* what, int error) {
    return Saved{std::string(what) + " " + fresh + ": " + std::strerror(error), error};
  };
  const int fd = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return failed("cannot create", errno);
  const int error = write_synced(fd, text);
  ::close(fd);
  if (error != 0) {
    ::unlink(fresh.c_str());  // what there is of it only takes room
    return failed("cannot write", error);
  }
  if (::rename(fresh.c_str(), path.c_str()) != 0) return failed("cannot put in place", errno);
  // The new name is on the disk only with its folder.
  if (const int unsynced = sync_folder_of(path); unsynced != 0) return failed("cannot sync the folder of", unsynced);
  return {};
}

ParameterStore::ParameterStore(std::string path, const contract::Params& started_with, const contract::Params& stored)
    : path_(std::move(path)), started_with_(started_with), stored_(stored) {
  synced_.emplace();
  for (std::size_t i = 0; i < contract::kParamCount; ++i) (*synced_)[i] = contract::get_param(started_with, i);
}

const contract::StoreReport& ParameterStore::look(const contract::ParamsInForce& in_force, std::uint64_t sequence, std::uint64_t now_ns) {
  if (in_force.defaults_after_damage != 0 || synced_ == in_force.kept) {
    report_ = {.stored = sequence, .tried = sequence};
    problem_.clear();
  } else if (sequence != report_.tried || now_ns >= retry_ns_) {
    store(in_force.kept, sequence);
    retry_ns_ = now_ns + kRetry_ns;
  }
  return report_;
}

contract::Params ParameterStore::file_content(const Values& kept) const {
  contract::Params content = stored_;
  for (std::size_t i = 0; i < contract::kParamCount; ++i) {
    const double started = contract::get_param(started_with_, i);
    const bool only_this_run = kept[i] == started && started != contract::get_param(stored_, i);
    if (!only_this_run) contract::set_param_unchecked(content, i, kept[i]);
  }
  return content;
}

void ParameterStore::store(const Values& kept, std::uint64_t sequence) {
  using contract::StoreProblem;
  report_.tried = sequence;
  if (path_.empty()) {
    report_.problem = StoreProblem::no_file;
    return;
  }
  const Saved saved = save_parameter_file(path_, file_content(kept));
  problem_ = saved.problem;
  if (problem_.empty()) {
    synced_ = kept;
    report_ = {.stored = sequence, .tried = sequence};
    return;
  }
  synced_.reset();
  report_.problem = saved.error == ENOSPC || saved.error == EDQUOT ? StoreProblem::disk_full : StoreProblem::failed;
}

}  // namespace hoist::run
