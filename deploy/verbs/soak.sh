# shellcheck shell=bash
# runs the whole system for hours and watches memory, files and lateness
#
# The real programs walk, drive, record and are watched by four readers, session after session. Every few seconds each program's memory,
# open files and threads, the database's log and the loop's figures are noted; at the end it prints what grew, by a straight line through the
# second half of the run. Fails when something grows, a program ends by itself, or the control thread asks for memory.
#
# options: --minutes N   how long (default 10)
#          --csv FILE    every reading, for a picture
#          --no-setup    leave the machine as it is
arguments=()
while [ $# -gt 0 ]; do
  case $1 in
    --minutes | --csv)
      [ -n "${2:-}" ] || die "$1 needs a value"
      arguments+=("$1" "$2")
      shift
      ;;
    *) common_option soak "$1" ;;
  esac
  shift
done
setup build
build_normal hoist-sim hoist-control hoist-server
exec python3 tests/system/soak.py build/bin "${arguments[@]}"
