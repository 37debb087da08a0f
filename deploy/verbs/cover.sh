# shellcheck shell=bash
# what the tests of the safety parts reach: lines, branches and MC/DC, and every mutant of the safety gate
#
# The safety gate must be at 100 % of lines and of MC/DC (each condition shown to decide by itself), or the verb fails. The other safety
# parts (supervisor, monitors, lease and remote driving) are printed beside it.
# options: --mutants     instead, changes each operator, constant and remembering statement of the parts that decide about motion (supervisor,
#                        modes, monitors, limiter, gate, commands, estimates) and of the drive and tilt nodes in turn: some test must fail
#          --sample N    with --mutants: N of the files that are complete, drawn by --seed, instead of all, which take hours
#          --seed TEXT   (default: the commit)
#          --file PART   with --mutants: only those in files whose name holds PART
#          --show        with --mutants: names also those not noticed in files that tests/mutants/known.tsv says are incomplete
#          --no-setup    leave the machine as it is
# shellcheck source=deploy/lib/tests.sh
source deploy/lib/tests.sh
mutants=
chosen=()
while [ $# -gt 0 ]; do
  case $1 in
    --mutants) mutants=yes ;;
    --sample | --seed | --file)
      [ -n "${2:-}" ] || die "$1 needs a value"
      chosen+=("$1" "$2")
      shift
      ;;
    --show) chosen+=("$1") ;;
    *) common_option cover "$1" ;;
  esac
  shift
done

if [ -n "$mutants" ]; then
  setup build test check
  build_normal core_mutants node_mutants
  status=0
  for program in core_mutants node_mutants; do judge_mutants "$program" "${chosen[@]}" || status=1; done
  exit "$status"
fi
[ ${#chosen[@]} -eq 0 ] || die "${chosen[0]} goes with --mutants"

setup build test cover
build_tree build/cover -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_COMPILER=clang++-19 -DHOIST_BENCH=OFF \
  "-DCMAKE_CXX_FLAGS=-O0 -g1 -w -fprofile-instr-generate -fcoverage-mapping -fcoverage-mcdc" -- test_core test_safety ||
  die "the coverage build failed: see above"
folder=$PWD/build/cover
for program in test_core test_safety; do
  LLVM_PROFILE_FILE="$folder/$program.profraw" "$folder/bin/$program" --gtest_brief=1
done
llvm-profdata-19 merge "$folder"/test_core.profraw "$folder"/test_safety.profraw -o "$folder/tests.profdata"
llvm-cov-19 report "$folder/bin/test_core" -object "$folder/bin/test_safety" -instr-profile="$folder/tests.profdata" \
  --show-region-summary=false --show-branch-summary --show-mcdc-summary control/core/output/safety_gate.hpp control/core/supervise/supervisor.cpp \
  control/core/supervise/fault_latch.cpp control/core/supervise/refusals.cpp control/core/supervise/release.cpp control/core/supervise/service.cpp \
  control/core/supervise/calibration_entry.cpp control/core/command/lease.hpp control/core/command/remote_drive.hpp control/core/monitor |
  tee "$folder/report.txt"
# Columns: file, functions, missed, share, lines, missed, share, branches, missed, share, conditions, missed, share.
awk '/safety_gate\.hpp/ { found = 1; whole = ($7 == "100.00%" && $NF == "100.00%") } END { exit !(found && whole) }' "$folder/report.txt" ||
  die "the safety gate is not covered to 100 % of lines and MC/DC (llvm-cov-19 show --show-mcdc says where)"
say "the safety gate: 100 % of lines and MC/DC"
