# shellcheck shell=bash
# kills and stalls programs, nodes and clients while the hoist runs
common_options chaos "$@"
not_here_yet chaos "the failure drills (tests/system/chaos) are not in this tree"
