#!/bin/bash
# Runs one suite for ctest, in the guest of vcan_vm.sh or on this machine: run_suite.sh guest|here NAME "PACKAGE..." COMMAND [ARGUMENT...]
# What is missing on this machine skips the suite (exit code 77) with the reason. Under `deploy/dev test` each case is counted: the suite
# leaves the same kind of report as a GoogleTest program does.
set -u
where=$1 name=$2 packages=$3
shift 3
here=$(dirname "$(realpath "$0")")
# GoogleTest's own convention: "xml:FOLDER/" asks for a report there.
reports=
case ${GTEST_OUTPUT:-} in xml:*/) reports=$(realpath "${GTEST_OUTPUT#xml:}") ;; esac

skip() {
  echo "skipped: $1"
  if [ -n "$reports" ]; then
    printf '<testsuites><testsuite name="%s"><testcase name="suite" classname="%s" result="skipped"><skipped message="%s:1&#x0A;%s"/></testcase></testsuite></testsuites>\n' \
      "$name" "$name" "$name" "$1" >"$reports/$name.xml"
  fi
  exit 77
}

missing=()
[ "$where" = here ] || packages="user-mode-linux iproute2 kmod $packages"
for package in $packages; do
  dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null | grep -q '^ii' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] || skip "Debian packages that are not installed: ${missing[*]}"
# A suite gets the folder of the programs, or is a program itself.
programs=()
for argument; do
  case $argument in
    */bin) programs+=("$argument"/hoist-{sim,control,server} "$argument/hoist") ;;
    */bin/test_*) programs+=("$argument") ;;
  esac
done
for program in "${programs[@]}"; do
  [ -x "$program" ] || skip "$(basename "$program") is not built"
done

# These suites walk in real time. Beside tests that compute without a pause they come first, where this user may say so; a real-time class
# instead stops user-mode Linux.
renice -n -15 -p $$ >/dev/null 2>&1 || true

[ -z "$reports" ] || export GTEST_OUTPUT="xml:$reports/$name.xml"
[ "$where" = guest ] || exec "$@"

for program in "${programs[@]}"; do
  if grep -qa '__asan_init\|__tsan_init' "$program"; then skip "sanitized programs do not start in user-mode Linux"; fi
done
# Only what this machine forbids or lacks is skipped. A guest that does not start for any other reason, or twice not in time, is a failure.
for _ in once again; do
  said=$("$here/vcan_vm.sh" -t 60 true 2>&1)
  code=$?
  [ "$code" -eq 124 ] || break
done
if [ "$code" -ne 0 ]; then
  cannot="cannot run on this machine"
  [[ "$code" -ne 125 || $said != *"$cannot"* ]] || skip "${said##*vcan_vm: }"
  echo "failed: the guest does not start ($code): $said"
  exit 1
fi
# ctest's own limit for a suite in the guest (CMakeLists.txt) has room for both starts and both runs.
arguments=(-t 580)
[ -z "$reports" ] || arguments+=(-w "$reports")
# The guest has one slow processor and the machine may be held up: what is broken fails twice. (The suites in Python repeat their cases
# themselves.)
"$here/vcan_vm.sh" "${arguments[@]}" "$@"
code=$?
case $code:$1 in
  0:* | 77:*) exit "$code" ;;
  *:*/bin/test_*) echo "failed; once more" ;;
  *) exit "$code" ;;
esac
exec "$here/vcan_vm.sh" "${arguments[@]}" "$@"
