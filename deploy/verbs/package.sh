# shellcheck shell=bash
# makes the Debian package and the installation image
common_options package "$@"
not_here_yet package "the service units and the router's set-up (deploy/systemd, deploy/network) are not in this tree"
