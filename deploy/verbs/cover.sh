# shellcheck shell=bash
# line coverage of the safety parts and of everything
common_options cover "$@"
not_here_yet cover "the coverage build and its thresholds (tests/safety) are not in this tree"
