// hoist archive: sessions of several hoists in one PostgreSQL database.
#include <unistd.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "db/archive/archive.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

namespace {

constexpr const char* kArchiveHelp =
    "usage: hoist archive create TARGET\n"
    "       hoist archive push DB TARGET [--device NAME] [--simulated]\n"
    "       hoist archive pull TARGET DB [--patient CODE] [--device NAME] [--from DAY] [--to DAY] [--uuid UUID]\n"
    "       hoist archive list TARGET [the same filters]\n"
    "       hoist archive verify TARGET [the same filters]\n"
    "       hoist archive erase TARGET UUID\n\n"
    "TARGET: a connection string or URI of PostgreSQL, \"dbname=archive host=server\". Keep the password out of it: use a password file\n"
    "(~/.pgpass) or a service; an empty TARGET takes everything from the environment (PGHOST, PGSERVICE ...).\n\n"
    "create  makes the archive in that database or brings it up to date, with the roles hoist_archive_push and hoist_archive_read\n"
    "push    sends ended sessions that the archive does not have, a visit at a time, and changed notes, codes and markers. Nothing is\n"
    "        sent twice; after an interruption run it again. Sessions of a simulator stay at home without --simulated.\n"
    "pull    writes sessions into a database of Hoist (made when it is missing) that no server is using; metrics, export and verify\n"
    "        work on it. Each is checked against the digest with which it was archived.\n"
    "list    one line of JSON per archived session; --device takes a name or the id of a hoist\n"
    "verify  reads every archived session and compares digests\n"
    "erase   takes a session out for good; no hoist brings it back\n\n"
    "Names and birth dates of patients never leave the hoist: the archive holds codes. Days are YYYY-MM-DD in UTC, both inclusive.\n";

struct Wish {
  std::vector<std::string> places;
  db::ArchiveQuery query;
  std::string device;
  bool simulated = false;
};

std::string host_name() {
  std::array<char, db::kMaxDevice_bytes + 1> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string();
}

// An empty answer: understood; else what is wrong.
std::string read_wish(std::span<const std::string_view> arguments, Wish& wish) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string argument(arguments[i]);
    if (argument == "--simulated") {
      wish.simulated = true;
      continue;
    }
    if (!argument.starts_with("--")) {
      wish.places.push_back(argument);
      continue;
    }
    if (i + 1 == arguments.size()) return argument + " needs a value";
    const std::string value(arguments[++i]);
    if (argument == "--device")
      wish.device = value, wish.query.device = value;
    else if (argument == "--patient")
      wish.query.patient = value;
    else if (argument == "--from")
      wish.query.from_day = value;
    else if (argument == "--to")
      wish.query.to_day = value;
    else if (argument == "--uuid")
      wish.query.uuid = value;
    else
      return "there is no option " + argument;
  }
  return {};
}

bool show_progress(std::uint64_t number, std::uint64_t of) {
  std::fprintf(stderr, isatty(STDERR_FILENO) != 0 && number < of ? "%llu of %llu\r" : "%llu of %llu\n",
               static_cast<unsigned long long>(number), static_cast<unsigned long long>(of));
  return true;
}

unsigned long long number(std::uint64_t value) { return value; }

int create(const Wish& wish) {
  const auto found = db::Archive::create(wish.places[0]);
  if (!found) return refuse("archive", found.error());
  std::puts(*found == 0 ? "the archive is made" : "the archive is up to date");
  return kDone;
}

int push(const Wish& wish) {
  auto database = db::Database::attach(wish.places[0]);
  if (!database) return refuse("archive", database.error());
  auto archive = db::Archive::connect(wish.places[1]);
  if (!archive) return refuse("archive", archive.error());
  const auto report = archive->push(*database, {wish.device.empty() ? host_name() : wish.device, wish.simulated}, show_progress);
  if (!report) return refuse("archive", report.error());
  std::printf("sent %llu, described again %llu, there already %llu; left here: %llu not ended, %llu of a simulator, %llu erased there\n",
              number(report->pushed), number(report->described), number(report->present), number(report->not_ended),
              number(report->simulated), number(report->erased));
  for (const std::string& sentence : report->refused) std::fprintf(stderr, "hoist archive: %s\n", sentence.c_str());
  return report->refused.empty() ? kDone : kPartly;
}

int pull(const Wish& wish) {
  auto archive = db::Archive::connect(wish.places[0]);
  if (!archive) return refuse("archive", archive.error());
  auto database = db::Database::open(wish.places[1]);
  if (!database) return refuse("archive", database.error());
  const auto report = archive->pull(*database, wish.query, show_progress);
  if (!report) return refuse("archive", report.error());
  std::printf("fetched %llu, here already %llu\n", number(report->pulled), number(report->present));
  return kDone;
}

int list(const Wish& wish) {
  auto archive = db::Archive::connect(wish.places[0]);
  if (!archive) return refuse("archive", archive.error());
  const auto sessions = archive->list(wish.query);
  if (!sessions) return refuse("archive", sessions.error());
  for (const db::ArchivedSession& session : *sessions) {
    const nlohmann::ordered_json line = {
        {"uuid", session.uuid},
        {"device", session.device},
        {"hoist_id", session.hoist_id.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(session.hoist_id)},
        {"subject", session.patient.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(session.patient)},
        {"started_utc", session.start_utc},
        {"duration_s", session.duration_s},
        {"simulated", session.simulated},
        {"note", session.note}};
    std::puts(line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  }
  return kDone;
}

int verify(const Wish& wish) {
  auto archive = db::Archive::connect(wish.places[0]);
  if (!archive) return refuse("archive", archive.error());
  const auto wrong = archive->verify(wish.query, show_progress);
  if (!wrong) return refuse("archive", wrong.error());
  for (const std::string& uuid : *wrong) std::printf("%s differs from its digest\n", uuid.c_str());
  if (wrong->empty()) std::puts("every session has its digest");
  return wrong->empty() ? kDone : kRefused;
}

int erase(const Wish& wish) {
  auto archive = db::Archive::connect(wish.places[0]);
  if (!archive) return refuse("archive", archive.error());
  const db::Status erased = archive->erase(wish.places[1]);
  if (!erased) return refuse("archive", erased.error());
  std::puts("erased");
  return kDone;
}

struct Action {
  std::string_view name;
  std::size_t places;
  int (*run)(const Wish&);
};
constexpr std::array kActions{Action{"create", 1, &create}, Action{"push", 2, &push},     Action{"pull", 2, &pull},
                              Action{"list", 1, &list},     Action{"verify", 1, &verify}, Action{"erase", 2, &erase}};

}  // namespace

int run_archive(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kArchiveHelp, stdout);
    return kDone;
  }
  Wish wish;
  if (const std::string wrong = arguments.empty() ? "say what to do" : read_wish(arguments.subspan(1), wish); !wrong.empty())
    return bad_usage("archive", wrong);
  for (const Action& action : kActions)
    if (action.name == arguments[0])
      return wish.places.size() == action.places
                 ? action.run(wish)
                 : bad_usage("archive", std::string(action.name) + " takes " + std::to_string(action.places) + " places");
  return bad_usage("archive", "create, push, pull, list, verify or erase");
}

}  // namespace hoist::tool
