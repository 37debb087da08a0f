#include "tests/unit/db/crash_vfs.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <vector>

namespace hoist::db::test {
namespace {

constexpr std::size_t kSector = 512;

struct Operation {
  bool truncate = false;
  std::size_t offset = 0;  // or the new length
  std::string data;
};
struct Content {
  std::string now, durable;
  std::vector<Operation> unsynced;
  std::vector<std::unique_ptr<char[]>> shared;  // the WAL index: memory that a power cut empties
};
struct Disk {
  std::map<std::string, std::shared_ptr<Content>> files;
  std::mt19937 random;
  std::uint64_t operations = 0, cut_at = 0;
  int temporary = 0;
  bool cut = false, lying = false;

  // True when the power is (now) gone.
  bool count() {
    if (cut) return true;
    ++operations;
    if (cut_at != 0 && operations >= cut_at) cut = true;
    return cut;
  }
};
Disk* disk = nullptr;

void apply(std::string& bytes, std::size_t offset, const char* data, std::size_t size) {
  if (bytes.size() < offset + size) bytes.resize(offset + size, '\0');
  std::memcpy(bytes.data() + offset, data, size);
}

struct File {
  sqlite3_file base;
  Content* content;
  std::string* name;
  int remove;
  std::shared_ptr<Content>* hold;
};
File* as_file(sqlite3_file* file) { return reinterpret_cast<File*>(file); }

int close_file(sqlite3_file* base) {
  File* file = as_file(base);
  if (file->remove != 0) disk->files.erase(*file->name);
  delete file->hold;
  delete file->name;
  return SQLITE_OK;
}
int read_file(sqlite3_file* base, void* to, int size, sqlite3_int64 offset) {
  const std::string& bytes = as_file(base)->content->now;
  const auto begin = std::min(static_cast<std::size_t>(offset), bytes.size());
  const std::size_t count = std::min(static_cast<std::size_t>(size), bytes.size() - begin);
  std::memcpy(to, bytes.data() + begin, count);
  std::memset(static_cast<char*>(to) + count, 0, static_cast<std::size_t>(size) - count);
  return count == static_cast<std::size_t>(size) ? SQLITE_OK : SQLITE_IOERR_SHORT_READ;
}
int write_file(sqlite3_file* base, const void* from, int size, sqlite3_int64 offset) {
  if (disk->cut) return SQLITE_IOERR_WRITE;
  Content& content = *as_file(base)->content;
  const auto* data = static_cast<const char*>(from);
  // The write during which the power goes is among those that may be torn.
  content.unsynced.push_back({false, static_cast<std::size_t>(offset), std::string(data, static_cast<std::size_t>(size))});
  apply(content.now, static_cast<std::size_t>(offset), data, static_cast<std::size_t>(size));
  return disk->count() ? SQLITE_IOERR_WRITE : SQLITE_OK;
}
int truncate_file(sqlite3_file* base, sqlite3_int64 size) {
  if (disk->count()) return SQLITE_IOERR_TRUNCATE;
  Content& content = *as_file(base)->content;
  content.unsynced.push_back({true, static_cast<std::size_t>(size), {}});
  content.now.resize(static_cast<std::size_t>(size), '\0');
  return SQLITE_OK;
}
int sync_file(sqlite3_file* base, int) {
  if (disk->count()) return SQLITE_IOERR_FSYNC;
  if (disk->lying) return SQLITE_OK;
  Content& content = *as_file(base)->content;
  content.durable = content.now;
  content.unsynced.clear();
  return SQLITE_OK;
}
int file_size(sqlite3_file* base, sqlite3_int64* size) {
  *size = static_cast<sqlite3_int64>(as_file(base)->content->now.size());
  return SQLITE_OK;
}
int lock_file(sqlite3_file*, int) { return SQLITE_OK; }
int check_lock(sqlite3_file*, int* held) {
  *held = 0;
  return SQLITE_OK;
}
int file_control(sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; }
int sector_size(sqlite3_file*) { return static_cast<int>(kSector); }
int characteristics(sqlite3_file*) { return 0; }
int shm_map(sqlite3_file* base, int region, int size, int extend, void volatile** out) {
  Content& content = *as_file(base)->content;
  const auto index = static_cast<std::size_t>(region);
  *out = nullptr;
  if (index >= content.shared.size() && extend == 0) return SQLITE_OK;
  while (content.shared.size() <= index) content.shared.push_back(std::make_unique<char[]>(static_cast<std::size_t>(size)));
  *out = content.shared[index].get();
  return SQLITE_OK;
}
int shm_lock(sqlite3_file*, int, int, int) { return SQLITE_OK; }
void shm_barrier(sqlite3_file*) {}
int shm_unmap(sqlite3_file* base, int remove) {
  if (remove != 0) as_file(base)->content->shared.clear();
  return SQLITE_OK;
}

const sqlite3_io_methods kMethods{2,         close_file,  read_file,  write_file,   truncate_file, sync_file,       file_size,
                                  lock_file, lock_file,   check_lock, file_control, sector_size,   characteristics, shm_map,
                                  shm_lock,  shm_barrier, shm_unmap,  nullptr,      nullptr};

int open_file(sqlite3_vfs*, const char* name, sqlite3_file* base, int flags, int* out_flags) {
  File* file = as_file(base);
  file->base.pMethods = nullptr;
  const std::string key = name != nullptr ? name : "temporary-" + std::to_string(++disk->temporary);
  auto found = disk->files.find(key);
  if (found == disk->files.end()) {
    if ((flags & SQLITE_OPEN_CREATE) == 0) return SQLITE_CANTOPEN;
    found = disk->files.emplace(key, std::make_shared<Content>()).first;
  }
  file->hold = new std::shared_ptr<Content>(found->second);
  file->content = found->second.get();
  file->name = new std::string(key);
  file->remove = (flags & SQLITE_OPEN_DELETEONCLOSE) != 0 ? 1 : 0;
  file->base.pMethods = &kMethods;
  if (out_flags != nullptr) *out_flags = flags;
  return SQLITE_OK;
}
int delete_file(sqlite3_vfs*, const char* name, int) {
  if (disk->count()) return SQLITE_IOERR_DELETE;
  return disk->files.erase(name) > 0 ? SQLITE_OK : SQLITE_IOERR_DELETE_NOENT;
}
int access_file(sqlite3_vfs*, const char* name, int, int* exists) {
  *exists = disk->files.contains(name) ? 1 : 0;
  return SQLITE_OK;
}
int full_path(sqlite3_vfs*, const char* name, int size, char* out) {
  sqlite3_snprintf(size, out, "%s", name);
  return SQLITE_OK;
}
int randomness(sqlite3_vfs*, int size, char* out) {
  for (int i = 0; i < size; ++i) out[i] = static_cast<char>(disk->random());
  return size;
}
int pause(sqlite3_vfs*, int micros) { return micros; }
int current_time(sqlite3_vfs*, double* days) {
  *days = 2461305.5;
  return SQLITE_OK;
}
int last_error(sqlite3_vfs*, int, char*) { return 0; }
int current_time_ms(sqlite3_vfs*, sqlite3_int64* ms) {
  *ms = 2461305LL * 86'400'000;
  return SQLITE_OK;
}

sqlite3_vfs make_vfs() {
  sqlite3_vfs vfs{};
  vfs.iVersion = 2;
  vfs.szOsFile = static_cast<int>(sizeof(File));
  vfs.mxPathname = 512;
  vfs.zName = CrashDisk::vfs_name();
  vfs.xOpen = open_file;
  vfs.xDelete = delete_file;
  vfs.xAccess = access_file;
  vfs.xFullPathname = full_path;
  vfs.xRandomness = randomness;
  vfs.xSleep = pause;
  vfs.xCurrentTime = current_time;
  vfs.xGetLastError = last_error;
  vfs.xCurrentTimeInt64 = current_time_ms;
  return vfs;
}
sqlite3_vfs the_vfs = make_vfs();

}  // namespace

const char* CrashDisk::vfs_name() { return "hoist-crash"; }

CrashDisk::CrashDisk(std::uint32_t seed) {
  disk = new Disk;
  disk->random.seed(seed);
  sqlite3_vfs_register(&the_vfs, 0);
}
CrashDisk::~CrashDisk() {
  sqlite3_vfs_unregister(&the_vfs);
  delete disk;
  disk = nullptr;
}
void CrashDisk::cut_after(std::uint64_t operations) { disk->cut_at = operations == 0 ? 0 : disk->operations + operations; }
bool CrashDisk::is_cut() const { return disk->cut; }
std::uint64_t CrashDisk::operations() const { return disk->operations; }
void CrashDisk::ignore_syncs(bool ignore) { disk->lying = ignore; }

void CrashDisk::restart() {
  for (auto& [name, content] : disk->files) {
    for (const Operation& operation : content->unsynced) {
      switch (disk->random() % 3) {
        case 0:
          break;
        case 1:
          if (operation.truncate)
            content->durable.resize(operation.offset, '\0');
          else
            apply(content->durable, operation.offset, operation.data.data(), operation.data.size());
          break;
        default:
          for (std::size_t at = 0; at < operation.data.size(); at += kSector)
            if (disk->random() % 2 == 0)
              apply(content->durable, operation.offset + at, operation.data.data() + at, std::min(kSector, operation.data.size() - at));
      }
    }
    content->unsynced.clear();
    content->now = content->durable;
    content->shared.clear();
  }
  disk->cut = false;
  disk->cut_at = 0;
}

}  // namespace hoist::db::test
