// Helpers for the compile-time soundness checks of the tables.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace hoist::contract {

// True when no two rows share their key. Quadratic, but only ever run by the compiler.
template <typename Row, std::size_t N, typename Key>
consteval bool unique_by(const std::array<Row, N>& rows, Key key) {
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = i + 1; j < N; ++j)
      if (key(rows[i]) == key(rows[j])) return false;
  return true;
}

template <typename Row, std::size_t N, typename Test>
consteval bool all_rows(const std::array<Row, N>& rows, Test test) {
  for (const Row& row : rows)
    if (!test(row)) return false;
  return true;
}

// FNV-1a over anything that two programs must agree on. Not a defence against malice, only against different builds.
constexpr std::uint64_t kHashStart = 14695981039346656037ULL;
constexpr std::uint64_t hash_bytes(std::uint64_t hash, std::string_view text) {
  for (char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 1099511628211ULL;
  return (hash ^ 0xFFU) * 1099511628211ULL;  // a separator, so that "ab","c" and "a","bc" differ
}
constexpr std::uint64_t hash_number(std::uint64_t hash, std::uint64_t value) {
  for (int i = 0; i < 8; ++i) hash = (hash ^ ((value >> (8 * i)) & 0xFFU)) * 1099511628211ULL;
  return hash;
}

}  // namespace hoist::contract
