# shellcheck shell=bash
# every hazard with its monitors, guards and tests; fails on a hole
#
# options: --write      also writes control/HAZARDS.gen.md
#          --no-setup   leave the machine as it is
arguments=()
for option in "$@"; do
  case $option in
    --write) arguments+=("$option") ;;
    *) common_option trace "$option" ;;
  esac
done
setup build
build_normal hoist-trace
exec build/bin/hoist-trace --top "$PWD" "${arguments[@]}"
