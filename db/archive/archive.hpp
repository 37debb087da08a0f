// An archive of several hoists in one PostgreSQL database: sessions go there once each, and come back as they were.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "db/archive/conditions.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"

namespace hoist::db {

class Postgres;

inline constexpr std::size_t kMaxDevice_bytes = 64;

struct PushOptions {
  std::string device;      ///< which hoist: 1 to kMaxDevice_bytes bytes
  bool simulated = false;  ///< also sessions of a simulator
};
struct PushReport {
  std::uint64_t pushed = 0;          ///< sessions that are new in the archive
  std::uint64_t described = 0;       ///< note, patient, exercise or markers changed since
  std::uint64_t present = 0;         ///< were there already, the same
  std::uint64_t not_ended = 0;       ///< still being recorded or folded: next time
  std::uint64_t simulated = 0;       ///< of a simulator, left out
  std::uint64_t erased = 0;          ///< taken out of the archive on purpose: not brought back
  std::vector<std::string> refused;  ///< a sentence per session that could not be pushed; the others were
};
struct ArchivedSession {
  std::string uuid, device, hoist_id, patient, start_utc, note;  ///< empty: without a code; recorded before hoists had an id
  double duration_s = 0;
  bool simulated = false;
};
struct PullReport {
  std::uint64_t pulled = 0, present = 0;
};
/// Called before each visit (or session without one): its number, from 1, and how many there are. False ends the work after the last commit.
using ArchiveProgress = std::function<bool(std::uint64_t number, std::uint64_t of)>;

class Archive {
 public:
  /// `target`: a connection string of libpq; empty = from libpq's environment. Errors: io (unreachable), wrong_state (no or older archive there:
  /// `create` first; or no right), newer_schema.
  static Result<Archive> connect(const std::string& target);
  /// Makes the archive in this database, or brings it up to date; needs a role that may make schemas and roles. Returns the version found.
  static Result<int> create(const std::string& target);

  Archive(Archive&&) noexcept;
  Archive& operator=(Archive&&) noexcept;
  ~Archive();

  /// Sends what the archive does not have, a visit per transaction: after any interruption call it again. What the archive has is known by uuid
  /// and digest. A refused session does not keep back the others.
  Result<PushReport> push(Database& database, const PushOptions& options, const ArchiveProgress& progress = {});
  /// Writes sessions into a file of ours, checked against the archive's digest; those that it has are left alone.
  Result<PullReport> pull(Database& database, const ArchiveQuery& query, const ArchiveProgress& progress = {});
  Result<std::vector<ArchivedSession>> list(const ArchiveQuery& query);
  /// Reads everything that matches and compares digests; returns the uuids that differ.
  Result<std::vector<std::string>> verify(const ArchiveQuery& query, const ArchiveProgress& progress = {});
  /// Takes a session out for good; not_found when it is not there.
  Status erase(const std::string& uuid);

 private:
  explicit Archive(std::unique_ptr<Postgres> postgres);
  std::unique_ptr<Postgres> postgres_;
};

}  // namespace hoist::db
