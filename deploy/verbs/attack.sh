# shellcheck shell=bash
# attacks a walking hoist with hostile clients, bus frames and killed programs; about nine minutes
#
# Simulator, core and server run on loopback in a folder of their own. After each attack the hoist still walks, or has stopped as specified;
# the server answers, the database is whole, STOP stops. Ends with the line `N passed, N failed, N skipped`. Before that the real Foxglove
# Studio drives, tunes and opens a recording in headless Chromium (tests/system/studio), with a line of its own.
# options: --only RE     only attacks whose name matches RE (tests/system/attack), and no Studio
#          --minutes N   no attack begins after so long (default 10)
#          --no-setup    leave the machine as it is
arguments=()
with_studio=yes
while [ $# -gt 0 ]; do
  case $1 in
    --only | --minutes)
      [ -n "${2:-}" ] || die "$1 needs a value"
      [ "$1" = --minutes ] || with_studio=
      arguments+=("$1" "$2")
      shift
      ;;
    *) common_option attack "$1" ;;
  esac
  shift
done
setup build attack ${with_studio:+test}
build_normal hoist-sim hoist-control hoist-server
status=0
if [ -n "$with_studio" ]; then
  [ -n "${no_setup:-}" ] || install_npm_packages tests/system/studio
  node tests/system/studio/studio.mjs --bin build/bin || status=1
fi
PYTHONDONTWRITEBYTECODE=1 python3 tests/system/attack/attack.py build/bin "${arguments[@]}" || status=1
exit "$status"
