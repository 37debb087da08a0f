# shellcheck shell=bash
# patients of many illnesses walk, fall and faint in virtual time; prints unasked stops and falls found in time
#
# options: --hours H, --falls N, --patient NAME, --seed S, --set NAME=VALUE, --jobs N (hoist-family --help says what they mean)
#          --tradeoff    for each guard: false stops against falls found, over a range of each threshold
#          --no-setup    leave the machine as it is
arguments=()
for option in "$@"; do
  case $option in
    --no-setup | -h | --help) common_option family "$option" ;;
    *) arguments+=("$option") ;;
  esac
done
setup build
build_normal hoist-family
exec build/bin/hoist-family "${arguments[@]}"
