# shellcheck shell=bash
# runs the whole system for hours and watches memory, files and lateness
#
# The real programs walk, drive, record and are watched by four readers, session after session. Every few seconds each program's memory,
# open files and threads, the database's log and the loop's figures are noted; at the end it prints what grew, by a straight line through the
# second half of the run. Fails when something grows, a program ends by itself, or the control thread asks for memory.
#
# Instead of that: --cuts cuts the power of a disk in memory that often, while it is recorded, migrated, deleted, backed up, restored and
# tidied by a rule of retention; then writers are killed and bytes flipped. --year makes a file of recordings of that size and measures what
# the server does with it.
#
# options: --minutes N   how long (default 10)
#          --csv FILE    every reading, for a picture
#          --cuts N      power cuts; 100000 take about a quarter of an hour
#          --year GB     a file of this size; a year of use has about 15
#          --no-setup    leave the machine as it is
arguments=() cuts='' year=''
while [ $# -gt 0 ]; do
  case $1 in
    --minutes | --csv)
      [ -n "${2:-}" ] || die "$1 needs a value"
      arguments+=("$1" "$2")
      shift
      ;;
    --cuts | --year)
      [ -n "${2:-}" ] || die "$1 needs a value"
      [ "$1" = --cuts ] && cuts=$2 || year=$2
      shift
      ;;
    *) common_option soak "$1" ;;
  esac
  shift
done
setup build
if [ -n "$cuts" ]; then
  build_normal test_db
  # In pieces, so that it is seen how far it is; each goes on with other rounds.
  piece=5000
  for ((from = 0; from < cuts; from += piece)); do
    HOIST_POWER_FROM=$from HOIST_POWER_CUTS=$((cuts - from < piece ? cuts - from : piece)) build/bin/test_db --gtest_filter='PowerCut.*' \
      --gtest_brief=1 || exit 1
    echo "power cuts: $((cuts - from < piece ? cuts : from + piece)) of $cuts"
  done & first=$!
  build/bin/test_db --gtest_filter='Kill.*:Integrity.NoFlippedByte*' --gtest_repeat=20 --gtest_brief=1
  wait "$first"
  exit
fi
if [ -n "$year" ]; then
  build_normal hoist-year
  folder=$(mktemp -d "${TMPDIR:-/var/tmp}/hoist-year-XXXXXX")
  trap 'rm -rf "$folder"' EXIT
  build/bin/hoist-year "$folder/year.db" "$year"
  exit
fi
build_normal hoist-sim hoist-control hoist-server
exec python3 tests/system/soak.py build/bin "${arguments[@]}"
