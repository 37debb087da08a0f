# shellcheck shell=bash
# makes the Debian package and the installation image
common_options package "$@"
not_here_yet package "the router's set-up (deploy/network) and the package itself are not in this tree"
