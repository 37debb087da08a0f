# shellcheck shell=bash
# attacks a walking hoist with hostile clients, bus frames and killed programs; about nine minutes
#
# Simulator, core and server run on loopback in a folder of their own. After each attack the hoist still walks, or has stopped as specified;
# the server answers, the database is whole, STOP stops. Ends with the line `N passed, N failed, N skipped`.
# options: --only RE     only attacks whose name matches RE (tests/system/attack)
#          --minutes N   no attack begins after so long (default 10)
#          --no-setup    leave the machine as it is
arguments=()
while [ $# -gt 0 ]; do
  case $1 in
    --only | --minutes)
      [ -n "${2:-}" ] || die "$1 needs a value"
      arguments+=("$1" "$2")
      shift
      ;;
    *) common_option attack "$1" ;;
  esac
  shift
done
setup build attack
build_normal hoist-sim hoist-control hoist-server
PYTHONDONTWRITEBYTECODE=1 exec python3 tests/system/attack/attack.py build/bin "${arguments[@]}"
