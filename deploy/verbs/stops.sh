# shellcheck shell=bash
# random cuts of link and computer; compares the stopping distance with the one shown
#
# options: --cuts N      how many of each of the six kinds (default 2000: twelve thousand in all)
#          --slips N     walks over slippery floor, for the track of encoders and gyroscope (default 100)
#          --no-setup    leave the machine as it is
cuts=2000
slips=100
while [ $# -gt 0 ]; do
  case $1 in
    --cuts | --slips)
      case ${2:-} in '' | 0 | *[!0-9]*) die "$1 needs a number above 0" ;; esac
      if [ "$1" = --cuts ]; then cuts=$2; else slips=$2; fi
      shift
      ;;
    *) common_option stops "$1" ;;
  esac
  shift
done
setup build
build_normal test_loop
HOIST_STOP_CUTS=$cuts HOIST_SLIP_SEEDS=$slips exec build/bin/test_loop --gtest_filter='StopDistance.*:Slip.*'
