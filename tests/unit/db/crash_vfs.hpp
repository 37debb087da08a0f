// A disk in memory whose power can be cut: an SQLite VFS that knows which writes have been synced. At the cut each write that was not synced is
// kept, dropped or torn by 512-byte sectors at random; then the survivors are all there is. kill -9 cannot show this, because the kernel keeps
// what a dead process wrote.
//
// Simplified: a file's creation and deletion are durable at once, and one process uses it.
#pragma once
#include <cstdint>
#include <random>
#include <string>

namespace hoist::db::test {

/// Registers the VFS under its name. One at a time.
class CrashDisk {
 public:
  explicit CrashDisk(std::uint32_t seed);
  ~CrashDisk();
  CrashDisk(const CrashDisk&) = delete;
  CrashDisk& operator=(const CrashDisk&) = delete;

  [[nodiscard]] static const char* vfs_name();
  /// The power goes at the n-th write, truncation or sync from now; every operation from then on fails. 0 = never.
  void cut_after(std::uint64_t operations);
  [[nodiscard]] bool is_cut() const;
  [[nodiscard]] std::uint64_t operations() const;
  /// The power comes back: unsynced writes meet their fate. All connections must be closed.
  void restart();
  /// A disk that says "synced" and has not: to show that the test would notice.
  void ignore_syncs(bool ignore);
};

}  // namespace hoist::db::test
