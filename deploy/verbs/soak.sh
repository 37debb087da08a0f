# shellcheck shell=bash
# runs the whole system for hours and watches memory, files and lateness
common_options soak "$@"
not_here_yet soak "the long run (tests/system/soak) is not in this tree"
