# shellcheck shell=bash
# installs what is missing, builds, and runs every test this machine can run
#
# The last line is `N passed, N failed, N skipped`; what is skipped is named with the reason before it.
# options: --no-setup     leave the machine as it is
#          --filter RE    only test programs (and the suites `web` and `e2e`) whose name matches RE
#          --thorough     long tests in full, and the proofs that the tests can fail, as `deploy/dev check` does
#          --sanitize     under AddressSanitizer and UndefinedBehaviourSanitizer (build/sanitize/), without the browser
# shellcheck source=deploy/lib/tests.sh
source deploy/lib/tests.sh

filter=.
sanitize=
targets=()
while [ $# -gt 0 ]; do
  case $1 in
    --sanitize) sanitize=yes ;;
    --thorough)
      export HOIST_THOROUGH=yes HOIST_PROOFS=yes
      targets=(all proofs)
      ;;
    --filter)
      [ $# -ge 2 ] || die "--filter needs a regular expression"
      filter=$2
      shift
      ;;
    *) common_option test "$1" ;;
  esac
  shift
done

results=$(new_results tests)
if [ -n "$sanitize" ]; then
  setup build test firmware
  build_sanitized "${targets[@]}" || die "the sanitized build failed: see above"
  run_ctest build/sanitize "$results" "$filter"
else
  setup_and_build build test firmware -- "${targets[@]}"
  build_web
  run_suites "$results" "$filter"
fi
tally "$results"
