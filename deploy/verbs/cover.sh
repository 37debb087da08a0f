# shellcheck shell=bash
# what the tests of the safety parts reach: lines, branches and MC/DC, and every mutant of the safety gate
#
# The safety gate must be at 100 % of lines and of MC/DC (each condition shown to decide by itself), or the verb fails. The other safety
# parts (supervisor, monitors, lease and remote driving) are printed beside it.
# options: --mutants     instead, changes each comparison, connective, number and remembering of the safety gate in turn: some test must fail
#          --no-setup    leave the machine as it is
mutants=
for option in "$@"; do
  case $option in
    --mutants) mutants=yes ;;
    *) common_option cover "$option" ;;
  esac
done

if [ -n "$mutants" ]; then
  setup build test
  have_node || die "$(no_node_reason)"
  build_normal gate_mutants
  build/bin/gate_mutants --gtest_brief=1 || die "the gate's tests fail without a mutant"
  node tests/mutants/gate_verdict.mjs build/tests/mutants/gate.tsv build/bin/gate_mutants tests/mutants/gate_equivalent.tsv
  exit
fi

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
