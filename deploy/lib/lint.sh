# shellcheck shell=bash
# What `format` and `check` share.

# Other major versions lay out a few things differently, so that two developers would undo each other's work.
no_clang_format() { echo "clang-format 14 is not on this machine (other versions lay things out differently)"; }
find_clang_format() {
  local candidate
  for candidate in clang-format-14 clang-format; do
    if command -v "$candidate" >/dev/null && "$candidate" --version | grep -q 'version 14\.'; then
      echo "$candidate"
      return 0
    fi
  done
  return 1
}

# The C++ sources that git knows, separated by NUL.
cpp_files() { git ls-files -z -- '*.cpp' '*.hpp' '*.h'; }
shell_files() { git ls-files -z -- deploy/dev .ci/run '*.sh'; }
