// Who may write a recording file: one program at a time. Two recorders on one file would close each other's sessions as interrupted.
#pragma once
#include <filesystem>
#include <memory>

#include "db/store/result.hpp"

namespace hoist::db {

/// A dying program may take this long to let go of its lock.
inline constexpr int kLockWait_ms = 1000;

class WriteLock {
 public:
  /// Locks FILE.lock beside the file (made when absent, never removed). The kernel lets go of it when the program ends, however it ends.
  /// Errors: busy (another program writes this file; the sentence says what to do), io.
  static Result<std::shared_ptr<WriteLock>> take(const std::filesystem::path& file);

  ~WriteLock();
  WriteLock(const WriteLock&) = delete;
  WriteLock& operator=(const WriteLock&) = delete;

 private:
  explicit WriteLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace hoist::db
