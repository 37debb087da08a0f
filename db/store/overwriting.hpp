// While it lives, what is overwritten or deleted on a connection leaves the file; at its end the log is cut (DECISIONS 9).
#pragma once
#include "db/store/sqlite.hpp"

namespace hoist::db {

class Overwriting {
 public:
  explicit Overwriting(sqlite3* handle) : handle_(handle) { try_execute(handle_, "PRAGMA secure_delete = ON"); }
  ~Overwriting() {
    try_execute(handle_, "PRAGMA secure_delete = OFF");
    try_execute(handle_, "PRAGMA wal_checkpoint(TRUNCATE)");
  }
  Overwriting(const Overwriting&) = delete;
  Overwriting& operator=(const Overwriting&) = delete;

 private:
  sqlite3* handle_;
};

}  // namespace hoist::db
