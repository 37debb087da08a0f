# shellcheck shell=bash
# What every verb shares: saying things, the set-up, the builds. Sourced by deploy/dev with the top of the tree as directory.

say() { printf 'hoist: %s\n' "$*" >&2; }
die() {
  say "$*"
  exit 1
}

# Prints a verb's own help: its comment block after the first line.
verb_help() { sed -n '2,/^[^#]/{s/^# \{0,1\}//p}' "deploy/verbs/$1.sh"; }

# common_option VERB OPTION: the options that every verb has; any other one is a mistake that is named.
common_option() {
  case $2 in
    --no-setup) no_setup=yes ;;
    -h | --help)
      verb_help "$1"
      exit 0
      ;;
    *) die "$1 does not know '$2' (try: deploy/dev $1 --help)" ;;
  esac
}

# For verbs that have no options of their own.
common_options() {
  local verb=$1 option
  shift
  for option in "$@"; do common_option "$verb" "$option"; done
}

# Unimplemented verbs name what is missing, and fail.
not_here_yet() {
  say "'deploy/dev $1' cannot do anything yet: $2"
  exit 3
}

# Compiling the server takes up to 1.5 GB per compiler, so memory limits the jobs before the cores do.
build_jobs() {
  local cores free_kb jobs
  cores=$(nproc)
  free_kb=$(awk '/^MemAvailable:/ {print $2}' /proc/meminfo)
  jobs=$((free_kb / 1572864))
  [ "$jobs" -ge 1 ] || jobs=1
  [ "$jobs" -le "$cores" ] || jobs=$cores
  echo "$jobs"
}

# build_tree FOLDER [cmake options...] -- [targets...]: configures once, then lets ninja find out what changed.
build_tree() {
  local folder=$1 options=() targets=()
  shift
  while [ $# -gt 0 ] && [ "$1" != -- ]; do
    options+=("$1")
    shift
  done
  [ $# -eq 0 ] || shift
  targets=("$@")
  # A changed option list configures again; ninja itself notices changed CMakeLists.
  local stamp=$folder/.hoist-options
  if [ ! -e "$folder/build.ninja" ] || [ "$(cat "$stamp" 2>/dev/null)" != "${options[*]}" ] ||
    [ build/.stamps/packages -nt "$stamp" ]; then
    mkdir -p "$folder"
    # Anew: a changed compiler would else lose the other options.
    cmake --fresh -S . -B "$folder" -G Ninja "${options[@]}" >"$folder/configure.log" 2>&1 || {
      cat "$folder/configure.log" >&2
      die "cmake could not configure $folder (its output is above)"
    }
    printf '%s' "${options[*]}" >"$stamp"
  fi
  # On a terminal ninja shows how far it is; a log gets a line each 10 s.
  if [ -t 2 ]; then
    ninja -C "$folder" -j "$(build_jobs)" "${targets[@]}" >&2 || return 1
  else
    NINJA_STATUS='[%f/%t] ' ninja -C "$folder" -j "$(build_jobs)" "${targets[@]}" | build_progress >&2
    [ "${PIPESTATUS[0]}" -eq 0 ] || return 1
  fi
}

build_progress_every_s=10
# Reads ninja's output: a line each 10 s says how far the build is; what is no step of the build passes. Not awk: Debian's waits for 4 KiB, minutes.
# The time left is told once a twentieth is done; what came before tells nothing.
build_progress() {
  local line begun=$EPOCHSECONDS told=$EPOCHSECONDS finished all left
  while IFS= read -r line; do
    if [[ $line =~ ^\[([0-9]+)/([0-9]+)\]\  ]]; then
      finished=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]}
      ((EPOCHSECONDS - told >= build_progress_every_s)) || continue
      told=$EPOCHSECONDS
      left=
      ((finished * 20 < all)) || left=", about $(((told - begun) * (all - finished) / finished / 60 + 1)) min left"
      printf 'hoist: building: %d of %d (%d %%)%s\n' "$finished" "$all" $((100 * finished / all)) "$left"
    elif [[ ! $line =~ ^ninja:\ (Entering\ directory|no\ work\ to\ do) ]]; then
      printf '%s\n' "$line"
    fi
  done
}

build_normal() {
  say "building (build/)"
  build_tree build -DCMAKE_BUILD_TYPE=RelWithDebInfo -- "$@" || die "the build failed: see above"
}

# build_watched FOLDER CHECKS [targets...]: under sanitizers, with little or no optimisation and small debug information (cmake/warnings.cmake), by
# clang where it is there: it compiles them in about half of g++'s time, and a second compiler sees other mistakes. Warnings are g++'s business.
build_watched() {
  local folder=$1 checks=$2 compiler=()
  shift 2
  if command -v clang++ >/dev/null; then compiler=(-DCMAKE_CXX_COMPILER=clang++ -DCMAKE_CXX_FLAGS=-w); fi
  build_tree "$folder" "${compiler[@]}" -DCMAKE_BUILD_TYPE=None "-DHOIST_SANITIZE=$checks" -DHOIST_BENCH=OFF -- "$@"
}
build_sanitized() {
  say "building with AddressSanitizer and UndefinedBehaviourSanitizer (build/sanitize/)"
  build_watched build/sanitize address,undefined "$@"
}
# Only clang's ThreadSanitizer: g++'s does not know fences and misses races.
build_threads() {
  say "building with ThreadSanitizer (build/thread/)"
  build_watched build/thread thread "$@"
}

# Builds the console's static files into web/dist when something in web/ is newer than the last build.
build_web() {
  if [ ! -e web/package.json ]; then
    say "the console (web/) is not in this tree; the server will run without screens"
    return 0
  fi
  local stamp=build/.stamps/web-dist
  mkdir -p build/.stamps
  # Folders count as well as files, so that a deleted file is noticed.
  if [ -e web/dist/index.html ] && [ -e "$stamp" ] &&
    [ -z "$(find web \( -path web/node_modules -o -path web/dist \) -prune -o ! -path web -newer "$stamp" -print -quit)" ]; then
    return 0
  fi
  say "building the console (web/dist)"
  local now=$stamp.new
  touch "$now"
  (cd web && npm run --silent build) >build/web-build.log 2>&1 || {
    cat build/web-build.log >&2
    die "the console did not build: see above"
  }
  mv "$now" "$stamp"
}

# Set by a verb's --no-setup.
no_setup=
# shellcheck source=deploy/lib/setup.sh
source deploy/lib/setup.sh
