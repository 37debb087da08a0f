// A disk whose every sync takes long: a layer over SQLite's own files, for all connections that are opened while it exists.
#pragma once
#include <sqlite3.h>

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <thread>

namespace hoist::tests {

/// One at a time. Connections opened under it must be closed before it ends.
class SlowDisk {
 public:
  explicit SlowDisk(std::chrono::milliseconds each_sync) {
    state().sync_ms = static_cast<int>(each_sync.count());
    state().syncs = state().ended = 0;
    below_ = sqlite3_vfs_find(nullptr);
    vfs_ = *below_;
    vfs_.zName = "hoist-slow";
    vfs_.pNext = nullptr;
    vfs_.pAppData = below_;
    vfs_.xOpen = [](sqlite3_vfs* own, const char* name, sqlite3_file* file, int flags, int* out) {
      auto* below = static_cast<sqlite3_vfs*>(own->pAppData);
      const int code = below->xOpen(below, name, file, flags, out);
      if (code == SQLITE_OK && file->pMethods != nullptr) file->pMethods = slowed(file->pMethods);
      return code;
    };
    sqlite3_vfs_register(&vfs_, 1);
  }
  ~SlowDisk() {
    sqlite3_vfs_unregister(&vfs_);
    sqlite3_vfs_register(below_, 1);
  }
  SlowDisk(const SlowDisk&) = delete;
  SlowDisk& operator=(const SlowDisk&) = delete;
  void set(std::chrono::milliseconds each_sync) { state().sync_ms = static_cast<int>(each_sync.count()); }
  [[nodiscard]] int syncs() const { return state().syncs; }
  /// The number of the sync under way, 0 for none. The same number twice: it lasted all the time between.
  [[nodiscard]] int running() const {
    const int begun = state().syncs;
    return begun > state().ended ? begun : 0;
  }

 private:
  struct State {
    std::atomic<int> sync_ms = 0, syncs = 0, ended = 0;
    std::mutex mutex;
    std::map<const sqlite3_io_methods*, sqlite3_io_methods> methods;
    std::map<const sqlite3_io_methods*, const sqlite3_io_methods*> originals;
  };
  static State& state() {
    static State state;
    return state;
  }
  static const sqlite3_io_methods* slowed(const sqlite3_io_methods* original) {
    const std::lock_guard lock(state().mutex);
    const auto [at, fresh] = state().methods.try_emplace(original, *original);
    if (fresh) state().originals[&at->second] = original;
    at->second.xSync = [](sqlite3_file* file, int flags) {
      const sqlite3_io_methods* below = nullptr;
      {
        const std::lock_guard held(state().mutex);
        below = state().originals.at(file->pMethods);
      }
      ++state().syncs;
      std::this_thread::sleep_for(std::chrono::milliseconds(state().sync_ms));
      const int code = below->xSync(file, flags);
      ++state().ended;
      return code;
    };
    return &at->second;
  }

  sqlite3_vfs* below_ = nullptr;
  sqlite3_vfs vfs_{};
};

}  // namespace hoist::tests
