# shellcheck shell=bash
# mutates the codecs' and the server's input under sanitizers
common_options fuzz "$@"
not_here_yet fuzz "there are no fuzz targets (tests/fuzz) in this tree"
