#include "control/run/heap_watch.hpp"

#include <cstdlib>
#include <new>

namespace {
thread_local std::uint64_t count = 0;
}
std::uint64_t hoist::run::heap_requests() noexcept { return count; }

// clang's ThreadSanitizer defines these functions itself: a program built with it counts nothing.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define HOIST_HEAP_IS_WATCHED_ELSEWHERE
#endif
#endif
#ifndef HOIST_HEAP_IS_WATCHED_ELSEWHERE
// The replaceable functions of the language; what else allocates in this program (the C library for threads and files) does not run in
// the thread of the steps.
void* operator new(std::size_t size) {
  ++count;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) { return operator new(size); }
// Replaced as well: AddressSanitizer has its own, whose memory the functions below may not give back.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++count;
  return std::malloc(size == 0 ? 1 : size);
}
void* operator new[](std::size_t size, const std::nothrow_t& no) noexcept { return operator new(size, no); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
#endif
