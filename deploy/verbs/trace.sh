# shellcheck shell=bash
# every hazard with its monitors, guards and tests; fails when one is missing
#
# options: --write      also writes control/HAZARDS.gen.md, and measures the reactions into control/REACTIONS.gen.md
#          --no-setup   leave the machine as it is
arguments=()
for option in "$@"; do
  case $option in
    --write) arguments+=("$option") ;;
    *) common_option trace "$option" ;;
  esac
done
setup build
build_normal hoist-trace hoist-reactions
[ ${#arguments[@]} -eq 0 ] || build/bin/hoist-reactions control/REACTIONS.gen.md >/dev/null
exec build/bin/hoist-trace --top "$PWD" "${arguments[@]}"
