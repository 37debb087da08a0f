// Storage for one object that is constructed at run time and never destroyed. Global objects with a non-zero initial value would need flash
// twice, and global constructors do not run.
#pragma once
#include <new>
#include <utility>

namespace hoist::firmware::cortex_m0 {

template <class T>
union Late {
  constexpr Late() : nothing{} {}
  constexpr ~Late() {}
  Late(const Late&) = delete;
  Late& operator=(const Late&) = delete;

  template <class... Arguments>
  T& make(Arguments&&... arguments) {
    return *new (&object) T(std::forward<Arguments>(arguments)...);
  }

  char nothing;
  T object;
};

}  // namespace hoist::firmware::cortex_m0
