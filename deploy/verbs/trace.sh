# shellcheck shell=bash
# follows one sample through the programs and shows where its time goes
common_options trace "$@"
not_here_yet trace "the trace points and their reader are not in this tree"
