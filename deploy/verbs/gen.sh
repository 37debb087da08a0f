# shellcheck shell=bash
# rewrites all generated files (*.gen.*) from the tables in control/contract and server/contract
#
# options: --check      write nothing; fail when a file is out of date
#          --no-setup   leave the machine as it is
arguments=(--top "$PWD")
for option in "$@"; do
  case $option in
    --check) arguments+=(--check) ;;
    *) common_option gen "$option" ;;
  esac
done
setup build
build_normal hoist-gen
build/bin/hoist-gen "${arguments[@]}"
