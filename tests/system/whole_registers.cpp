// Preloaded into user-mode Linux by vcan_vm.sh: its 6.1 keeps 2696 bytes of extended registers per process, but where the processor has AMX the
// kernel takes back the whole state only (11 kB), and the guest's first process dies in put_fp_registers. Each write is made whole here: no
// process of the guest has asked to use AMX, so the part that user-mode Linux does not keep is always empty.
// Sources: ptrace(2), PTRACE_SETREGSET; arch/x86/um/os-Linux/registers.c; the kernel's xstateregs_set.
#include <dlfcn.h>
#include <elf.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstddef>
#include <cstdint>

namespace {
using Ptrace = long (*)(__ptrace_request, ...);
const auto kPtrace = reinterpret_cast<Ptrace>(dlsym(RTLD_NEXT, "ptrace"));

long set_whole_state(pid_t process, const iovec& part) {
  static std::array<std::byte, 16384> whole{};  // user-mode Linux has one thread, and small stacks
  static std::size_t size = 0;
  const auto type = static_cast<std::uintptr_t>(NT_X86_XSTATE);
  if (size == 0) {
    iovec first{whole.data(), whole.size()};
    if (kPtrace(PTRACE_GETREGSET, process, type, &first) != 0) return -1;
    size = first.iov_len;
  }
  std::copy_n(static_cast<const std::byte*>(part.iov_base), std::min(part.iov_len, size), whole.begin());
  iovec all{whole.data(), size};
  return kPtrace(PTRACE_SETREGSET, process, type, &all);
}
}  // namespace

extern "C" long ptrace(__ptrace_request request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  const auto process = va_arg(arguments, pid_t);
  auto* const address = va_arg(arguments, void*);
  auto* const data = va_arg(arguments, void*);
  va_end(arguments);
  if (request == PTRACE_SETREGSET && reinterpret_cast<std::uintptr_t>(address) == NT_X86_XSTATE) {
    return set_whole_state(process, *static_cast<const iovec*>(data));
  }
  return kPtrace(request, process, address, data);
}
