# shellcheck shell=bash
# installs what is missing and builds everything; programs land in build/bin/
#
# options: --no-setup   leave the machine as it is
#          TARGET...    build only these ninja targets
targets=()
while [ $# -gt 0 ]; do
  case $1 in
    -*) common_option build "$1" ;;
    *) targets+=("$1") ;;
  esac
  shift
done
setup build
if [ ${#targets[@]} -gt 0 ]; then
  build_normal "${targets[@]}"
else
  build_normal all hoist-bench
  build_web
fi
say "built: programs are in build/bin/"
