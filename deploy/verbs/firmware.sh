# shellcheck shell=bash
# cross-compiles the Cortex-M0 images and checks their size
common_options firmware "$@"
not_here_yet firmware "the boards' start-up code (firmware/boards/lpc11c24, stm32f072) is not in this tree"
