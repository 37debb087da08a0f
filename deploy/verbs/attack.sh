# shellcheck shell=bash
# tries what a hostile client on the network would
common_options attack "$@"
not_here_yet attack "the attack runs (tests/system/attack) are not in this tree"
