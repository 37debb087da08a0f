# shellcheck shell=bash
# all benchmarks in one table, with ratios to references measured in the same run
#
# options: --no-setup   leave the machine as it is; everything else is passed on to build/bin/hoist-bench
arguments=()
for option in "$@"; do
  case $option in
    --no-setup | -h | --help) common_option bench "$option" ;;
    *) arguments+=("$option") ;;
  esac
done
setup build bench
build_normal all hoist-bench
[ -x build/bin/hoist-bench ] || not_here_yet bench "build/bin/hoist-bench (tests/bench) is not in this tree"
exec build/bin/hoist-bench "${arguments[@]}"
