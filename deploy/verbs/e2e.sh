# shellcheck shell=bash
# drives the real programs through the console in headless Chromium
#
# options: --no-setup   leave the machine as it is
# shellcheck source=deploy/lib/tests.sh
source deploy/lib/tests.sh
common_options e2e "$@"
setup build test
build_normal
build_web
results=$(new_results e2e)
run_browser_tests "$results" .
tally "$results"
