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
  {
    as_root apt-get update &&
      as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@"
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

# setup GROUP...: makes this machine able to do what the groups of deploy/packages are for.
setup() {
  local missing=() wanted=()
  if [ -n "${no_setup:-}" ]; then
    use_newest_node
    return 0
  fi
  if command -v dpkg-query >/dev/null; then
    mapfile -t wanted < <(wanted_packages "$@")
    # Node may come from elsewhere, so check for the program, not the package.
    if [ -z "$(node_major node)" ]; then wanted+=(nodejs); fi
    command -v npm >/dev/null || wanted+=(npm)
    mapfile -t missing < <(missing_packages "${wanted[@]}")
    [ ${#missing[@]} -eq 0 ] || install_packages "${missing[@]}"
  else
    say "this is not Debian (no dpkg-query): nothing is installed; deploy/packages lists what is needed"
  fi
  install_npm_packages web
  install_npm_packages tests/web
  install_npm_packages tests/system/peers
  install_npm_packages tests/system/exports
  install_npm_packages tests/api_lint
  install_npm_packages tests/system/tools
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
