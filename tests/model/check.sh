#!/usr/bin/env bash
# check.sh FOLDER MODEL [NAME...]: searches every state of MODEL.pml for a broken assertion. Without names the whole rules, which must hold;
# with names the rules without those, which must fail. Works in FOLDER.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
skip=77
for program in spin gcc; do
  command -v "$program" >/dev/null || { echo "skipped: no $program on this machine"; exit "$skip"; }
done
folder=$1
model=$2
shift 2
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
spin "${@/#/-D}" -a "$here/$model.pml" >spin.log
gcc -O2 -DSAFETY -DCOLLAPSE -DVECTORSZ=256 -DMEMLIM=4096 -w -o pan pan.c
./pan -m200000 -w24 >pan.log
grep -E 'errors:|states, stored|assertion violated|max search depth|out of memory' pan.log
if grep -qE 'out of memory|max search depth too small' pan.log; then
  echo "the search did not end: it proves nothing"
  exit 1
fi
if [ $# -eq 0 ]; then grep -q 'errors: 0$' pan.log; else grep -q 'assertion violated' pan.log; fi
