#!/bin/bash
# Runs a command inside a throw-away Linux guest that has SocketCAN (vcan, slcan, can-gw), whatever the machine's own kernel has, and
# returns the command's exit code.
#   vcan_vm.sh [-m MIB] [-t SECONDS] [-w FOLDER] [-k] COMMAND [ARGUMENT...]
#   -w FOLDER  what the command writes under FOLDER stays; everything else it writes is lost
#   -k         prints the guest's console log at the end
# The guest is user-mode Linux from Debian's package user-mode-linux: an ordinary process of an ordinary user, about 2 s and 50 MB a run. It
# sees this file system (same paths, folder, environment; IN_VCAN_VM is set) and starts with lo and vcan0 up. The command is root in there,
# reads nothing, and its output and errors come out together. No network but lo, one processor, a clock of 100 Hz: never measure time in it,
# and sanitized programs do not start (its address space is too small).
# Exit code: the command's; 124 when the time was over; 125 when the guest did not start or died, with "cannot run on this machine" when that is
# no fault of the guest.
set -u
[ "${1:-}" = --guest ] || [ "${1:-}" = --inside ] || caller_environment=$(export -p)
export PATH=/usr/sbin:/usr/bin:/sbin:/bin

# First stage in the guest: a writable root over the read-only one.
if [ "${1:-}" = --guest ]; then
  run=$2
  # shellcheck source=/dev/null
  . "$run/settings"
  insmod "$modules/kernel/fs/overlayfs/overlay.ko"
  mount -t tmpfs tmpfs /mnt && mkdir /mnt/up /mnt/wk /mnt/r
  mount -t overlay -o lowerdir=/,upperdir=/mnt/up,workdir=/mnt/wk overlay /mnt/r || exec sleep 1
  [ -z "$writable" ] || mount -t hostfs -o "$writable" none "/mnt/r$writable"
  exec chroot /mnt/r /bin/bash "$self" --inside "$run"
fi

# Second stage in the guest: mounts, modules, interfaces, then the command.
if [ "${1:-}" = --inside ]; then
  run=$2
  # shellcheck source=/dev/null
  . "$run/settings"
  mount -t proc proc /proc
  mount -t sysfs sys /sys
  mount -t devtmpfs dev /dev 2>/dev/null
  mkdir -p /dev/pts /dev/shm
  mount -t devpts devpts /dev/pts
  mount -t tmpfs tmpfs /dev/shm
  mount -t tmpfs tmpfs /run
  while read -r module; do insmod "$modules/$module"; done <"$run/modules"
  ip link set lo up
  ip link add vcan0 type vcan
  ip link set vcan0 up
  # shellcheck source=/dev/null
  (. "$run/command")
  code=$?
  sync
  echo "VCAN_VM_CODE=$code" >/dev/console
  echo o >/proc/sysrq-trigger
  sleep 5
  exit 0
fi

# On the machine itself.
memory=256 limit=120 writable='' keep=''
while getopts m:t:w:k option; do
  case $option in
    m) memory=$OPTARG ;;
    t) limit=$OPTARG ;;
    w) writable=$(realpath "$OPTARG") ;;
    k) keep=yes ;;
    *) exit 125 ;;
  esac
done
shift $((OPTIND - 1))
[ $# -gt 0 ] || {
  sed -n 2,13p "$0"
  exit 125
}
self=$(realpath "$0")
kernel=/usr/bin/linux.uml
modules=$(echo /usr/lib/uml/modules/*)
if [ ! -x "$kernel" ] || [ ! -d "$modules" ]; then
  echo "vcan_vm: package user-mode-linux is missing" >&2
  exit 125
fi
run=$(mktemp -d "${TMPDIR:-/tmp}/vcan_vm.XXXXXX")

# shellcheck disable=SC2317  # called by the trap
clean_up() {
  local left
  # A guest that was ended by force may leave stopped children behind; this run's folder is in their command line and in no other's.
  mapfile -t left < <(pgrep -f -- "--guest $run")
  [ ${#left[@]} -eq 0 ] || kill -9 "${left[@]}" 2>/dev/null
  rm -rf "$run"
}
trap clean_up EXIT

# The modules with what they need, in the order in which they must be loaded.
load_order() {
  local module
  for module; do
    grep -E "/$module\.ko:" "$modules/modules.dep" | tr -d : | tr ' ' '\n' | grep . | tac
  done | awk '!seen[$0]++'
}
load_order can-raw can-gw vcan slcan >"$run/modules"
{
  printf 'modules=%q\n' "$modules"
  printf 'writable=%q\n' "$writable"
  printf 'self=%q\n' "$self"
} >"$run/settings"
# A processor with AMX has more registers than user-mode Linux knows (whole_registers.cpp).
preload=()
if grep -q -m 1 amx_tile /proc/cpuinfo; then
  c++ -std=c++20 -O2 -shared -fPIC -o "$run/registers.so" "$(dirname "$self")/whole_registers.cpp" || exit 125
  preload=("LD_PRELOAD=$run/registers.so")
fi
{
  printf '%s\nexport IN_VCAN_VM=yes\nstty -F /dev/tty1 -opost\ncd %q\n' "$caller_environment" "$PWD"
  printf '%q ' "$@"
  echo '</dev/null >/dev/tty1 2>&1'
} >"$run/command"

log=$run/console.log
exec 3>&1
env "${preload[@]}" timeout -k 5 "$limit" "$kernel" mem="${memory}M" rootfstype=hostfs rootflags=/ ro quiet \
  con=null con0=null,fd:1 con1=null,fd:3 ssl=null init=/bin/bash -- "$self" --guest "$run" </dev/null >"$log" 2>&1
ended=$?
[ -z "$keep" ] || cat "$log" >&2
if [ "$ended" -eq 124 ] || [ "$ended" -eq 137 ]; then
  echo "vcan_vm: not done within $limit s" >&2
  exit 124
fi
code=$(tr -d '\r' <"$log" | sed -n 's/.*VCAN_VM_CODE=\([0-9]*\).*/\1/p' | tail -n 1)
# Some machines forbid what user-mode Linux lives on (tracing of processes, executable memory) or have too little of it.
reason=$(grep -m 1 -E '^ptrace: Operation not permitted|^check_ptrace|must be not mounted noexec|likely just ran out of space' "$log")
[ -n "$code" ] || [ -z "$reason" ] || {
  echo "vcan_vm: user-mode Linux cannot run on this machine: $reason" >&2
  exit 125
}
[ -n "$code" ] || {
  echo "vcan_vm: the guest gave no result (its process ended with $ended); its console:" >&2
  tail -n 20 "$log" >&2
  exit 125
}
exit "$code"
