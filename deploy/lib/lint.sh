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

# clang-tidy costs seconds per source, so it gets a fixed time: what was changed last comes first, and it says how far it came.
tidy_time_s=60

# Sources of the compile database, those of the latest commits first. Tests are left out: GoogleTest's macros cost much and say little.
tidy_sources() {
  local folder=$1
  {
    git log -n 30 --name-only --pretty=format: -- '*.cpp'
    git ls-files -- '*.cpp'
  } | awk 'NF && !seen[$0]++' | grep -v '^tests/' | while read -r source; do
    if [ -e "$source" ] && grep -qF "/$source\"" "$folder/compile_commands.json"; then echo "$source"; fi
  done
}

# tidy_one FOLDER SOURCE: what it finds fails; so does a source that clang cannot read, whose other findings would be lost.
# Compiler warnings are g++'s business; clang's differ from the ones the code is written for.
tidy_one() { clang-tidy -p "$1" --quiet --extra-arg=-w "$2" 2>/dev/null; }

run_clang_tidy() {
  local folder=$1/tidy sources total looked=0 failed=0 end=$((SECONDS + tidy_time_s)) batch jobs
  export -f tidy_one
  # clang cannot read g++'s precompiled headers, and looks at each source by itself.
  cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DHOIST_JOIN=OFF >"$1/tidy.log" 2>&1 || {
    cat "$1/tidy.log"
    return 1
  }
  mapfile -t sources < <(tidy_sources "$folder")
  total=${#sources[@]}
  jobs=$(build_jobs)
  while [ "$looked" -lt "$total" ] && [ "$SECONDS" -lt "$end" ]; do
    batch=("${sources[@]:looked:jobs}")
    # shellcheck disable=SC2016 # the inner shell expands them
    printf '%s\0' "${batch[@]}" | xargs -0 -P "$jobs" -I {} bash -c 'tidy_one "$1" "$2"' tidy "$folder" {} || failed=1
    looked=$((looked + ${#batch[@]}))
  done
  echo "clang-tidy looked at $looked of $total sources (those changed last first, at most $tidy_time_s s)"
  return "$failed"
}

# Types are checked by `tsc` when the console is built; ESLint looks for likely mistakes that types allow, Prettier for the layout.
check_console_code() { (cd web && node_modules/.bin/eslint .); }
check_console_layout() { (cd web && node_modules/.bin/prettier --check --log-level warn .); }

# The limit of the formatters holds for what they leave alone, too: long texts and comments. Tables of texts, pages and generated files are
# read in another way; tests, and the files of web/.prettierignore, have not been laid out yet.
line_columns_most=150
check_line_lengths() {
  ! git ls-files -z -- '*.cpp' '*.hpp' '*.h' '*.ts' '*.tsx' '*.mjs' '*.js' '*.css' '*.sh' '*.py' deploy/dev \
    ':!*.gen.*' ':!server/contract/schemas.cpp' ':!web/src/text' ':!tests' |
    grep -zvxFf <(sed 's,^[^#],web/&,' web/.prettierignore) |
    LC_ALL=C.UTF-8 xargs -0 grep -nHE "^.{$((line_columns_most + 1))}"
}
