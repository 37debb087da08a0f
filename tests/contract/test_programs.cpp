// What deploy/cmake/hardening.cmake promises, read back from the programs themselves, and the modes of the files they write.
#include <elf.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/temporary_folder.hpp"

namespace hoist::test {
namespace {

namespace fs = std::filesystem;

constexpr std::array kPrograms{"hoist", "hoist-control", "hoist-server", "hoist-sim"};
fs::path program(const std::string& name) { return fs::path(HOIST_BINARY_DIR) / "bin" / name; }

// As much of a 64-bit ELF file of this machine as the questions below need. Every offset is checked by at().
class Elf {
 public:
  explicit Elf(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
    header_ = at<Elf64_Ehdr>(0);
    for (std::size_t i = 0; i < header_.e_phnum; ++i) segments_.push_back(at<Elf64_Phdr>(header_.e_phoff + i * header_.e_phentsize));
    for (std::size_t i = 0; i < header_.e_shnum; ++i) sections_.push_back(at<Elf64_Shdr>(header_.e_shoff + i * header_.e_shentsize));
  }
  [[nodiscard]] bool is_elf() const {
    return std::memcmp(header_.e_ident, ELFMAG, SELFMAG) == 0 && header_.e_ident[EI_CLASS] == ELFCLASS64;
  }
  [[nodiscard]] unsigned type() const { return header_.e_type; }
  [[nodiscard]] std::optional<Elf64_Phdr> segment(unsigned type) const {
    for (const Elf64_Phdr& one : segments_)
      if (one.p_type == type) return one;
    return std::nullopt;
  }
  // The value of an entry of the dynamic section, 0 when there is none.
  [[nodiscard]] std::uint64_t dynamic(std::int64_t tag) const {
    const auto where = segment(PT_DYNAMIC);
    for (std::uint64_t offset = 0; where && offset < where->p_filesz; offset += sizeof(Elf64_Dyn))
      if (const auto row = at<Elf64_Dyn>(where->p_offset + offset); row.d_tag == tag) return row.d_un.d_val;
    return 0;
  }
  // Whether the program takes a function whose name ends so from a library.
  [[nodiscard]] bool imports(std::string_view ending) const {
    bool found = false;
    each_symbol(SHT_DYNSYM, [&](const Elf64_Sym& symbol, std::string_view text) {
      found = found || (symbol.st_shndx == SHN_UNDEF && text.ends_with(ending));
    });
    return found;
  }
  // The first bytes of one of its own functions.
  [[nodiscard]] std::string code(std::string_view name, std::size_t count) const {
    std::string out;
    each_symbol(SHT_SYMTAB, [&](const Elf64_Sym& symbol, std::string_view text) {
      if (text != name || symbol.st_shndx == SHN_UNDEF || symbol.st_shndx >= sections_.size()) return;
      const Elf64_Shdr& in = sections_[symbol.st_shndx];
      out = bytes_.substr(in.sh_offset + (symbol.st_value - in.sh_addr), count);
    });
    return out;
  }
  // Features of every part of the program: GNU_PROPERTY_X86_FEATURE_1_AND.
  [[nodiscard]] std::uint32_t x86_features() const {
    constexpr std::uint32_t kFeatures = 0xc0000002U;
    const auto note = segment(PT_GNU_PROPERTY);
    if (!note) return 0;
    // Name size, descriptor size, type, "GNU\0", then rows of type, size and value in steps of eight bytes.
    const auto size = at<std::uint32_t>(note->p_offset + 4);
    for (std::uint64_t offset = 16; offset + 12 <= 16 + std::uint64_t{size};) {
      const std::uint64_t row = note->p_offset + offset;
      if (at<std::uint32_t>(row) == kFeatures) return at<std::uint32_t>(row + 8);
      offset += 8 + (at<std::uint32_t>(row + 4) + 7U) / 8U * 8U;
    }
    return 0;
  }

 private:
  template <typename T>
  [[nodiscard]] T at(std::uint64_t offset) const {
    T value{};
    if (offset <= bytes_.size() && bytes_.size() - offset >= sizeof value) std::memcpy(&value, bytes_.data() + offset, sizeof value);
    return value;
  }
  template <typename Visit>
  void each_symbol(unsigned table, Visit visit) const {
    for (const Elf64_Shdr& section : sections_) {
      if (section.sh_type != table || section.sh_link >= sections_.size()) continue;
      const std::uint64_t names = sections_[section.sh_link].sh_offset;
      for (std::uint64_t offset = 0; offset < section.sh_size; offset += sizeof(Elf64_Sym)) {
        const auto symbol = at<Elf64_Sym>(section.sh_offset + offset);
        if (names + symbol.st_name < bytes_.size()) visit(symbol, std::string_view(bytes_.c_str() + names + symbol.st_name));
      }
    }
  }

  std::string bytes_;
  Elf64_Ehdr header_{};
  std::vector<Elf64_Phdr> segments_;
  std::vector<Elf64_Shdr> sections_;
};

TEST(Programs, AddressesAreRandomAndFixedBeforeMain) {
  for (const char* name : kPrograms) {
    const Elf elf(program(name));
    ASSERT_TRUE(elf.is_elf()) << name;
    EXPECT_EQ(elf.type(), unsigned{ET_DYN}) << name << " is not position-independent";
    EXPECT_NE(elf.dynamic(DT_FLAGS_1) & DF_1_PIE, 0U) << name;
    EXPECT_NE(elf.dynamic(DT_FLAGS_1) & DF_1_NOW, 0U) << name << " is bound lazily, so its table of addresses stays writable";
    EXPECT_TRUE(elf.segment(PT_GNU_RELRO)) << name;
    const auto stack = elf.segment(PT_GNU_STACK);
    EXPECT_TRUE(stack && (stack->p_flags & PF_X) == 0) << name << " has an executable stack";
    EXPECT_EQ(elf.dynamic(DT_TEXTREL), 0U) << name;
  }
}

TEST(Programs, MistakesEndThem) {
  for (const char* name : kPrograms) {
    const Elf elf(program(name));
    EXPECT_TRUE(elf.imports("__stack_chk_fail")) << name;
    EXPECT_TRUE(elf.imports("_ZSt21__glibcxx_assert_failPKciS0_S0_")) << name << " does not check its indices";
#ifndef HOIST_SANITIZED
    EXPECT_TRUE(elf.imports("_chk")) << name << " is not fortified";
#endif
  }
}

TEST(Programs, ReturnsAndIndirectCallsAreMarked) {
#if defined(__x86_64__)
  constexpr std::uint32_t kShadowStack = 2;
  for (const char* name : kPrograms) {
    const Elf elf(program(name));
    EXPECT_NE(elf.x86_features() & kShadowStack, 0U) << name;
    EXPECT_EQ(elf.code("main", 4), "\xf3\x0f\x1e\xfa") << name << ": no endbr64 where main begins";
  }
#else
  GTEST_SKIP() << "the marks are those of x86-64";
#endif
}

// A program that runs until the end of the test; it is started with the usual umask, under which files are world-readable.
class Running {
 public:
  explicit Running(std::vector<std::string> arguments) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return;
    pid_ = ::fork();
    if (pid_ == 0) {
      ::umask(022);
      ::dup2(ends[0], 0);
      const int nothing = ::open("/dev/null", O_WRONLY);
      ::dup2(nothing, 1);
      ::dup2(nothing, 2);
      std::vector<char*> values;
      for (std::string& one : arguments) values.push_back(one.data());
      values.push_back(nullptr);
      ::execv(values[0], values.data());
      ::_exit(127);
    }
    ::close(ends[0]);
    input_ = ends[1];
  }
  ~Running() {
    if (pid_ > 0) {
      ::kill(pid_, SIGTERM);
      ::waitpid(pid_, nullptr, 0);
    }
    if (input_ >= 0) ::close(input_);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  [[nodiscard]] std::string umask() const {
    std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("Umask:")) return line.substr(line.find_last_of(" \t") + 1);
    return "it has ended";
  }

 private:
  pid_t pid_ = -1;
  int input_ = -1;
};

// Polls until true, or for 30 s: another process gives no event when ready.
template <typename Question>
bool until(Question question) {
  for (int i = 0; i < 3000; ++i) {
    if (question()) return true;
    ::poll(nullptr, 0, 10);
  }
  return false;
}

// H28: parameters, database, captures, tokens and sockets are for the user of the hoist only, whatever the shell's umask is.
TEST(Programs, WhatTheyWriteIsForTheirUserOnly) {
  const test::TemporaryFolder folder;
  const auto file = [&folder](const char* name) { return (folder / name).string(); };
  {
    const Running tool({program("hoist"), "laws", "normalise"});
    EXPECT_TRUE(until([&] { return tool.umask() == "0077"; })) << tool.umask();
    const Running sim({program("hoist-sim"), "--pty-link", file("can"), "--control", file("sim.sock")});
    ASSERT_TRUE(until([&] { return fs::is_symlink(folder / "can"); }));
    const Running control({program("hoist-control"), "--bus", "slcan:" + file("can"), "--socket", file("core.sock"), "--params",
                           file("parameters.json"), "--capture", file("bus.log"), "--no-realtime"});
    const Running server(
        {program("hoist-server"), "--socket", file("core.sock"), "--port", "0", "--db", file("hoist.db"), "--token-file", file("token")});
    for (const char* name : {"sim.sock", "core.sock", "bus.log", "hoist.db", "hoist.db-wal", "hoist.db.lock", "token", "token.sessions"})
      EXPECT_TRUE(until([&] { return fs::exists(folder / name); })) << name;
    EXPECT_EQ(sim.umask(), "0077");
    EXPECT_EQ(control.umask(), "0077");
    EXPECT_EQ(server.umask(), "0077");
    for (const fs::directory_entry& entry : fs::directory_iterator(folder.path())) {
      if (entry.is_symlink()) continue;
      EXPECT_EQ(entry.status().permissions() & fs::perms(0177), fs::perms::none) << entry.path();
    }
  }
}

}  // namespace
}  // namespace hoist::test
