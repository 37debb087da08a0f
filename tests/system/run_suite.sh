#!/bin/bash
# Runs one suite in the guest of vcan_vm.sh, for ctest: run_suite.sh NAME "PACKAGE..." COMMAND [ARGUMENT...]
# What is missing on this machine skips the suite (exit code 77) with the reason. Under `deploy/dev test` each case is counted: the suite
# leaves the same kind of report as a GoogleTest program does.
set -u
name=$1 packages=$2
shift 2
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
for package in user-mode-linux iproute2 kmod $packages; do
  dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null | grep -q '^ii' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] || skip "Debian packages that are not installed: ${missing[*]}"
for program; do
  case $program in
    */bin/*) [ -x "$program" ] || skip "$(basename "$program") is not built" ;;
  esac
done

arguments=(-t 280)
if [ -n "$reports" ]; then
  arguments+=(-w "$reports")
  export GTEST_OUTPUT="xml:$reports/$name.xml"
fi
# A sanitizer's programs cannot start in the guest.
case ${1:-} in
  */bin/*) if grep -qa '__asan_init\|__tsan_init' "$1"; then skip "sanitized programs do not start in user-mode Linux"; fi ;;
esac
exec "$here/vcan_vm.sh" "${arguments[@]}" "$@"
