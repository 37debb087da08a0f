// Sessions as plain rows in one SQLite file, for the sqlite3 shell, Python and R. Its tables: sessions (with manifest and figures as JSON),
// columns (units and meanings), samples, events, markers, parameters, parameter_changes, gaps. Patients are codes; who was signed in stays out.
// An SQLite file cannot be written front to back: it is built beside the recordings, without a name, and then read from its beginning.
#pragma once
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "db/export/bundle_plan.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {

class SqliteWriter : public BundleSource {
 public:
  /// Throws SqlFailure.
  SqliteWriter(Database& database, std::vector<SessionId> sessions, ExportOptions options);
  /// One session, inside the read transaction of its export.
  SqliteWriter(Database& database, SessionInfo session, ExportOptions options);
  ~SqliteWriter() override;
  bool next(std::string& out) override;
  [[nodiscard]] double progress() const override;

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  struct LiveValue {
    std::string name;
    bool whole;  // numbers without decimals
  };
  void take_source(Result<SessionInfo> session);
  void gather_columns();
  void create_file();
  void create_tables();
  void describe();
  void write_session(const nlohmann::json& manifest);
  void write_manifest(const nlohmann::json& manifest);
  void write_events();
  bool write_samples();
  bool read(std::string& out);

  Database& database_;
  std::vector<SessionId> sessions_;
  ExportOptions options_;
  std::size_t begun_ = 0;  // sessions
  int file_ = -1;
  std::uint64_t read_ = 0;
  std::unique_ptr<sqlite3, Close> handle_;  // nothing before and once the file is whole
  std::unique_ptr<Statement> insert_;       // into samples
  std::vector<LiveValue> columns_;          // of samples
  // The session under way.
  std::unique_ptr<ExportSource> source_;
  std::vector<std::size_t> which_;  // columns to read: the chosen ones, then tick and time
  std::vector<int> places_;         // of the chosen ones in `insert_`
  bool described_ = false;
};

}  // namespace hoist::db
