#include "tests/support/crash_disk.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <vector>

namespace hoist::tests {
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
  // Locks of the connections: a database that another one has open must not be tidied up by the first that closes it.
  int readers = 0, reserved = 0, exclusive = 0;
  std::array<int, SQLITE_SHM_NLOCK> shm_readers{}, shm_writers{};
};
struct Disk {
  std::map<std::string, std::shared_ptr<Content>> files;
  std::mt19937 random;
  std::uint64_t operations = 0, cut_at = 0;
  int temporary = 0;
  bool cut = false, lying = false, full = false;
  std::uint32_t fails = 0;  // of 2^32

  // True when the power is off.
  bool count() {
    if (cut) return true;
    ++operations;
    if (cut_at != 0 && operations >= cut_at) cut = true;
    return cut;
  }
  bool fails_now() { return fails != 0 && static_cast<std::uint32_t>(random()) < fails; }
};
thread_local Disk* disk = nullptr;

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
  int level;                          // of the file's lock
  std::uint32_t shm_read, shm_wrote;  // bit per lock of the WAL index
};
File* as_file(sqlite3_file* file) { return reinterpret_cast<File*>(file); }

int unlock_file(sqlite3_file* base, int level);
int shm_lock(sqlite3_file* base, int offset, int count, int flags);

int close_file(sqlite3_file* base) {
  File* file = as_file(base);
  (void)unlock_file(base, SQLITE_LOCK_NONE);
  (void)shm_lock(base, 0, SQLITE_SHM_NLOCK, SQLITE_SHM_UNLOCK);
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
  if (disk->cut || disk->fails_now()) return SQLITE_IOERR_WRITE;
  Content& content = *as_file(base)->content;
  if (disk->full && static_cast<std::size_t>(offset) + static_cast<std::size_t>(size) > content.now.size()) return SQLITE_FULL;
  const auto* data = static_cast<const char*>(from);
  // The write during which the power goes is among those that may be torn.
  content.unsynced.push_back({false, static_cast<std::size_t>(offset), std::string(data, static_cast<std::size_t>(size))});
  apply(content.now, static_cast<std::size_t>(offset), data, static_cast<std::size_t>(size));
  return disk->count() ? SQLITE_IOERR_WRITE : SQLITE_OK;
}
int truncate_file(sqlite3_file* base, sqlite3_int64 size) {
  if (disk->count() || disk->fails_now()) return SQLITE_IOERR_TRUNCATE;
  Content& content = *as_file(base)->content;
  content.unsynced.push_back({true, static_cast<std::size_t>(size), {}});
  content.now.resize(static_cast<std::size_t>(size), '\0');
  return SQLITE_OK;
}
int sync_file(sqlite3_file* base, int) {
  if (disk->count() || disk->fails_now()) return SQLITE_IOERR_FSYNC;
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
// In one process and thread nothing may wait: an unavailable lock is busy.
int lock_file(sqlite3_file* base, int level) {
  File& file = *as_file(base);
  Content& content = *file.content;
  if (level <= file.level) return SQLITE_OK;
  const int own = file.level >= SQLITE_LOCK_SHARED ? 1 : 0;
  if (own == 0) {
    if (content.exclusive > 0) return SQLITE_BUSY;
    ++content.readers;
    file.level = SQLITE_LOCK_SHARED;
  }
  if (level >= SQLITE_LOCK_RESERVED && file.level < SQLITE_LOCK_RESERVED) {
    if (content.reserved > 0) return SQLITE_BUSY;
    ++content.reserved;
    file.level = SQLITE_LOCK_RESERVED;
  }
  if (level >= SQLITE_LOCK_EXCLUSIVE) {
    if (content.readers > 1) return SQLITE_BUSY;
    ++content.exclusive;
    file.level = SQLITE_LOCK_EXCLUSIVE;
  }
  return SQLITE_OK;
}
int unlock_file(sqlite3_file* base, int level) {
  File& file = *as_file(base);
  Content& content = *file.content;
  if (file.level >= SQLITE_LOCK_EXCLUSIVE && level < SQLITE_LOCK_EXCLUSIVE) --content.exclusive;
  if (file.level >= SQLITE_LOCK_RESERVED && level < SQLITE_LOCK_RESERVED) --content.reserved;
  if (file.level >= SQLITE_LOCK_SHARED && level < SQLITE_LOCK_SHARED) --content.readers;
  if (level < file.level) file.level = level;
  return SQLITE_OK;
}
bool disk_reserved(sqlite3_file* base) { return as_file(base)->content->reserved > 0; }
int check_lock(sqlite3_file* base, int* held) {
  *held = disk_reserved(base) ? 1 : 0;
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
int shm_lock(sqlite3_file* base, int offset, int count, int flags) {
  File& file = *as_file(base);
  Content& content = *file.content;
  const bool exclusive = (flags & SQLITE_SHM_EXCLUSIVE) != 0;
  for (int i = offset; i < offset + count; ++i) {
    const std::uint32_t bit = 1U << i;
    auto& readers = content.shm_readers[static_cast<std::size_t>(i)];
    auto& writers = content.shm_writers[static_cast<std::size_t>(i)];
    if ((flags & SQLITE_SHM_UNLOCK) != 0) {
      if ((file.shm_wrote & bit) != 0) --writers;
      if ((file.shm_read & bit) != 0) --readers;
      file.shm_wrote &= ~bit;
      file.shm_read &= ~bit;
      continue;
    }
    const int others_read = readers - ((file.shm_read & bit) != 0 ? 1 : 0), others_write = writers - ((file.shm_wrote & bit) != 0 ? 1 : 0);
    if (others_write > 0 || (exclusive && others_read > 0)) {
      // All or nothing.
      if (i > offset) (void)shm_lock(base, offset, i - offset, SQLITE_SHM_UNLOCK | (flags & (SQLITE_SHM_EXCLUSIVE | SQLITE_SHM_SHARED)));
      return SQLITE_BUSY;
    }
    if (exclusive && (file.shm_wrote & bit) == 0) ++writers, file.shm_wrote |= bit;
    if (!exclusive && (file.shm_read & bit) == 0) ++readers, file.shm_read |= bit;
  }
  return SQLITE_OK;
}
void shm_barrier(sqlite3_file*) {}
int shm_unmap(sqlite3_file* base, int remove) {
  if (remove != 0) as_file(base)->content->shared.clear();
  return SQLITE_OK;
}

const sqlite3_io_methods kMethods{2,         close_file,  read_file,  write_file,   truncate_file, sync_file,       file_size,
                                  lock_file, unlock_file, check_lock, file_control, sector_size,   characteristics, shm_map,
                                  shm_lock,  shm_barrier, shm_unmap,  nullptr,      nullptr};

int open_file(sqlite3_vfs*, const char* name, sqlite3_file* base, int flags, int* out_flags) {
  File* file = as_file(base);
  *file = {};
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

CrashDisk::CrashDisk(std::uint32_t seed, const Image& image) {
  disk = new Disk;
  disk->random.seed(seed);
  for (const auto& [name, bytes] : image) {
    auto content = std::make_shared<Content>();
    content->now = content->durable = bytes;
    disk->files.emplace(name, std::move(content));
  }
  static const int registered = sqlite3_vfs_register(&the_vfs, 0);
  (void)registered;
}
CrashDisk::~CrashDisk() {
  delete disk;
  disk = nullptr;
}
CrashDisk::Image CrashDisk::image() const {
  Image image;
  for (const auto& [name, content] : disk->files) image.emplace(name, content->now);
  return image;
}
void CrashDisk::cut_after(std::uint64_t operations) { disk->cut_at = operations == 0 ? 0 : disk->operations + operations; }
bool CrashDisk::is_cut() const { return disk->cut; }
std::uint64_t CrashDisk::operations() const { return disk->operations; }
void CrashDisk::ignore_syncs(bool ignore) { disk->lying = ignore; }

bool CrashDisk::rename(const std::string& from, const std::string& to) {
  if (disk->count()) return false;
  auto moved = disk->files.extract(from);
  if (moved.empty()) return false;
  disk->files.erase(to);
  moved.key() = to;
  disk->files.insert(std::move(moved));
  return true;
}

void CrashDisk::cut_now() { disk->cut = true; }
void CrashDisk::fill(bool full) { disk->full = full; }
void CrashDisk::fail(double share) { disk->fails = static_cast<std::uint32_t>(share * 4294967295.0); }

void CrashDisk::restart_process() {
  for (auto& [name, content] : disk->files) content->shared.clear();
  disk->cut = false;
  disk->cut_at = 0;
}

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

}  // namespace hoist::tests
