#!/usr/bin/env bash
# supervise.sh NAME COMMAND...: keeps one program running until TERM; started by `deploy/dev run` only.
# A program that dies is started again after a short pause. One that dies at once, again and again, will not get better
# by itself: then this gives up, so that the reason stays visible.
set -euo pipefail

back_off_s=0.5
quick_death_s=2
quick_deaths_limit=20
term_grace_tries=50 # of 0.1 s

name=$1
shift
child=
stop() {
  trap '' TERM INT
  if [ -n "$child" ]; then
    kill -TERM "$child" 2>/dev/null || exit 0
    for ((tries = 0; tries < term_grace_tries; tries++)); do
      kill -0 "$child" 2>/dev/null || exit 0
      sleep 0.1
    done
    echo "hoist: $name does not end; killing it" >&2
    kill -KILL "$child" 2>/dev/null || exit 0
  fi
  exit 0
}
trap stop TERM INT

quick_deaths=0
while :; do
  started=$SECONDS
  # The program gets TERM when this supervisor is killed outright.
  setpriv --pdeathsig TERM "$@" &
  child=$!
  status=0
  wait "$child" || status=$?
  child=
  if [ $((SECONDS - started)) -lt "$quick_death_s" ]; then quick_deaths=$((quick_deaths + 1)); else quick_deaths=0; fi
  if [ "$quick_deaths" -ge "$quick_deaths_limit" ]; then
    echo "hoist: $name died $quick_deaths times in a row right after its start (last exit code $status): giving up" >&2
    exit 1
  fi
  echo "hoist: $name ended (exit code $status); starting it again in $back_off_s s" >&2
  sleep "$back_off_s"
done
