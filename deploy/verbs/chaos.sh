# shellcheck shell=bash
# random sessions with random faults in virtual time; what must always hold is checked in every step
#
# options: --sessions N, --seed S, --length SECONDS, --no-faults, --loss SHARE, --story, --jobs N (hoist-chaos --help says what they mean)
#          --no-setup    leave the machine as it is
# A session that breaks a promise is shown with its seed: `deploy/dev chaos --sessions 1 --story --seed S` tells it again, step by step.
arguments=()
for option in "$@"; do
  case $option in
    --no-setup | -h | --help) common_option chaos "$option" ;;
    *) arguments+=("$option") ;;
  esac
done
setup build
build_normal hoist-chaos
exec build/bin/hoist-chaos "${arguments[@]}"
