# shellcheck shell=bash
# Setup: installs missing Debian and npm packages only. Repeating it costs a fraction of a second.

node_major_least=20

debian_release() {
  local id=""
  # shellcheck source=/dev/null
  id=$(. /etc/os-release 2>/dev/null && echo "${VERSION_ID:-}")
  # Debian's testing has no number; it is at least the release after the newest one we name.
  echo "${id%%.*}"
}

# wanted_packages GROUP...: the lines of deploy/packages that hold for this Debian.
wanted_packages() {
  local release
  release=$(debian_release)
  [ -n "$release" ] || release=99
  awk -v groups=" $* " -v release="$release" '
    /^[[:space:]]*(#|$)/ { next }
    index(groups, " " $1 " ") == 0 { next }
    $3 == "" || $3 == release || ($3 ~ /\+$/ && release + 0 >= $3 + 0) { print $2 }' deploy/packages
}

# Prints those of the given packages ("A|B" means either) that dpkg does not have.
missing_packages() {
  local have line alternative found
  have=$(dpkg-query -W -f '${db:Status-Abbrev} ${Package}\n' 2>/dev/null | awk '$1 == "ii" {print $2}')
  for line in "$@"; do
    found=
    for alternative in ${line//|/ }; do
      if grep -qxF "$alternative" <<<"$have"; then found=yes; fi
    done
    [ -n "$found" ] || echo "${line%%|*}"
  done
}

# Runs a command as root: directly, or through sudo where that needs no terminal.
as_root() {
  if [ "$(id -u)" = 0 ]; then
    "$@"
  elif command -v sudo >/dev/null; then
    sudo "$@"
  else
    return 127
  fi
}

install_packages() {
  if [ "$(id -u)" != 0 ] && ! command -v sudo >/dev/null; then
    die "these Debian packages are missing and neither root nor sudo is at hand: $*
       as root:  apt-get install $*"
  fi
  say "installing Debian packages: $*"
  mkdir -p build
  # Unpacked files need no sync each (a quarter of the time): what a power cut spoils is installed once more.
  {
    as_root apt-get update &&
      as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends -o Dpkg::Options::=--force-unsafe-io "$@"
  } >build/apt.log 2>&1 || {
    tail -n 30 build/apt.log >&2
    die "apt-get could not install them (its last lines are above, all of them in build/apt.log)"
  }
  # Installed packages decide what can be built: every tree is configured again (build_tree).
  mkdir -p build/.stamps
  touch build/.stamps/packages
}

node_major() { "$1" --version 2>/dev/null | sed -n 's/^v\([0-9]*\)\..*/\1/p'; }

# npm's own check reads its whole tree; a stamp of the lock file's checksum answers in a millisecond.
install_npm_packages() {
  local folder=$1 sum
  [ -e "$folder/package-lock.json" ] || return 0
  sum=$(sha256sum <"$folder/package-lock.json")
  if [ "$(cat "$folder/node_modules/.hoist-lock" 2>/dev/null)" = "$sum" ]; then return 0; fi
  say "installing npm packages ($folder)"
  mkdir -p build
  (cd "$folder" && npm ci --no-audit --no-fund) >build/npm.log 2>&1 || {
    tail -n 30 build/npm.log >&2
    die "npm ci failed in $folder (its last lines are above)"
  }
  check_npm_node "$folder"
  echo "$sum" >"$folder/node_modules/.hoist-lock"
}

# The npm package `node` fetches its program by a script of its own, which no lock file covers. Nothing runs that program before it was held
# against deploy/lib/node.sha256.
check_npm_node() {
  local program=$1/node_modules/node/bin/node wanted
  [ -e "$program" ] || return 0
  wanted=$(awk -v machine="$(uname -m)" '$1 == machine {print $2}' deploy/lib/node.sha256)
  if [ "$(sha256sum <"$program")" = "$wanted  -" ]; then return 0; fi
  rm -f "$program"
  die "$program was not the one that deploy/lib/node.sha256 names for $(uname -m); it was removed and not run"
}

# setup_debian GROUP...: the Debian packages of these groups in deploy/packages.
setup_debian() {
  local missing=() wanted=()
  if ! command -v dpkg-query >/dev/null; then
    say "this is not Debian (no dpkg-query): nothing is installed; deploy/packages lists what is needed"
    return 0
  fi
  mapfile -t wanted < <(wanted_packages "$@")
  # Node may come from elsewhere, so check for the program, not the package.
  if [ -z "$(node_major node)" ]; then wanted+=(nodejs); fi
  command -v npm >/dev/null || wanted+=(npm)
  mapfile -t missing < <(missing_packages "${wanted[@]}")
  [ ${#missing[@]} -eq 0 ] || install_packages "${missing[@]}"
}

# setup_npm GROUP...: the console's npm packages, and with the groups test or check those of the tests' clients.
setup_npm() {
  local folder
  install_npm_packages web
  [[ " $* " =~ " test "|" check " ]] || return 0
  for folder in tests/web tests/system/peers tests/system/exports tests/api_lint tests/system/tools; do install_npm_packages "$folder"; done
}

# setup GROUP...: makes this machine able to do what the groups of deploy/packages are for.
setup() {
  if [ -z "${no_setup:-}" ]; then
    setup_debian "$@"
    setup_npm "$@"
  fi
  use_newest_node
}

# setup_and_build GROUP... -- TARGET...: as setup, with the normal build made while npm fetches: C++ needs none of its packages.
setup_and_build() {
  local groups=() npm=
  while [ "$1" != -- ]; do
    groups+=("$1")
    shift
  done
  shift
  if [ -z "${no_setup:-}" ]; then
    setup_debian "${groups[@]}"
    setup_npm "${groups[@]}" &
    npm=$!
  fi
  build_normal "$@"
  if [ -n "$npm" ]; then wait "$npm" || exit 1; fi
  use_newest_node
}

# Debian 12's Node is 18. The npm package `node`, a pinned development dependency of web/, carries the binary itself.
use_newest_node() {
  local major
  major=$(node_major node)
  if [ "${major:-0}" -ge "$node_major_least" ]; then return 0; fi
  check_npm_node web
  if [ -x web/node_modules/node/bin/node ]; then
    PATH=$PWD/web/node_modules/node/bin:$PATH
    export PATH
  fi
}

no_node_reason() { echo "no Node >= $node_major_least on this machine"; }
have_node() { [ "$(node_major node || echo 0)" -ge "$node_major_least" ] 2>/dev/null; }
