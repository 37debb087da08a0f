# shellcheck shell=bash
# Running the suites. Each leaves its results in one folder; tally.mjs counts the cases of all of them.
#
# A results folder holds: ctest.xml and gtest/*.xml (C++), vitest.json (web), e2e.json (browser) and steps.tsv
# (one line each: passed|failed|skipped, name, reason; separated by tabs).

# A test program that hangs is a failure, not a longer wait. The longest takes two minutes alone on two processors.
ctest_timeout_s=900

# Makes an empty results folder and prints its name.
new_results() {
  local folder=$PWD/build/results/$1
  rm -rf "$folder"
  mkdir -p "$folder/gtest"
  : >"$folder/steps.tsv"
  echo "$folder"
}

# record_step RESULTS passed|failed|skipped NAME [REASON]
record_step() { printf '%s\t%s\t%s\n' "$2" "$3" "${4:-}" >>"$1/steps.tsv"; }

# ended_badly RESULTS NAME REPORT: for a suite whose program failed. Unless its JSON report names a failed case, the suite itself counts as failed.
ended_badly() { grep -qsE '"status": ?"failed"' "$3" || record_step "$1" failed "$2" "ended badly, and its report names no failed case"; }

# run_ctest BUILD_FOLDER RESULTS FILTER [COMMAND...]: COMMAND starts ctest. A failing program's whole output is shown; the tally counts it.
# With HOIST_PROOFS the proofs, too (target `proofs` of tests/CMakeLists.txt).
run_ctest() {
  local folder=$1 results=$2 filter=$3 size jobs status=0 proofs=(-LE proof)
  shift 3
  [ -z "${HOIST_PROOFS:-}" ] || proofs=()
  say "running the C++ tests of $folder/"
  # What computes takes two places, the guest of tests/system as well; what waits takes one: the other three chains there, and the parts of a program
  # (hoist_add_test). The chains and the parts begin. More programs that compute would starve what walks in real time.
  jobs=$((2 * $(build_jobs) + 3))
  # ctest cuts long outputs of failing programs by default; we want all of it (10 MB is more than any prints).
  size=10000000
  ASAN_OPTIONS=${ASAN_OPTIONS:-detect_stack_use_after_return=1} \
    UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1:halt_on_error=1} \
    GTEST_BRIEF=${GTEST_BRIEF:-1} GTEST_OUTPUT="xml:$results/gtest/" \
    "$@" ctest --test-dir "$folder" -j "$jobs" --timeout "$ctest_timeout_s" --output-on-failure \
    --test-output-size-failed "$size" -R "$filter" "${proofs[@]}" --output-junit "$results/ctest.xml" </dev/null || status=$?
  # The tally takes from the report which program crashed, hung or could not start. ctest's own status is 0, or 8 when tests failed.
  if [ "$status" -ne 0 ] && [ "$status" -ne 8 ]; then
    record_step "$results" failed "ctest of $folder/" "ended with status $status"
  elif ! grep -qsxE '</testsuite>|[[:space:]]*tests="0"' "$results/ctest.xml"; then
    record_step "$results" failed "ctest of $folder/" "its report is missing or incomplete"
  fi
  : >"$results/ctest.ended"
}

# The programs in which two threads share something: the server with its recorder, and the shared memory between core and server.
thread_targets=(test_server test_publish)

# build_thread_tests RESULTS: builds them; run_thread_tests RESULTS: runs them. A race makes the program end badly, which the tally counts.
build_thread_tests() {
  if ! command -v clang++ >/dev/null; then
    record_step "$1" skipped "ThreadSanitizer" "no clang++ on this machine"
  elif ! build_threads "${thread_targets[@]}"; then
    record_step "$1" failed "build with ThreadSanitizer" "see above"
  fi
}
run_thread_tests() {
  local results=$1 filter fixed=()
  [ ! -s "$results/steps.tsv" ] || return 0  # not built
  # clang 14's runtime exits at once where the kernel randomises addresses by more bits than it supports.
  if setarch -R true 2>/dev/null; then fixed=(setarch -R); fi
  filter=$(IFS='|' && echo "${thread_targets[*]}")
  run_ctest build/thread "$results" "^($filter)(_[0-9]+)?\$" "${fixed[@]}"
}

# judge_mutants PROGRAM OPTION...: its mutants by its tests (tests/mutants/verdict.py); build it before.
judge_mutants() {
  local program=$1
  shift
  /usr/bin/python3 tests/mutants/verdict.py "build/bin/$program" "build/tests/mutants/$program/mutants.tsv" tests/mutants/known.tsv \
    --seed "$(git rev-parse --short HEAD 2>/dev/null || echo 1)" "$@"
}

run_web_tests() {
  local results=$1 filter=$2
  [[ web =~ $filter ]] || return 0
  if [ ! -e web/package.json ]; then
    record_step "$results" skipped web "web/ has no package.json in this tree"
  elif ! have_node; then
    record_step "$results" skipped web "$(no_node_reason)"
  elif [ ! -d web/node_modules ]; then
    record_step "$results" skipped web "npm packages are not installed (leave out --no-setup)"
  else
    say "running the console's unit tests (web/)"
    (cd web && npm test --silent -- --reporter=default --reporter=json --outputFile.json="$results/vitest.json") </dev/null ||
      ended_badly "$results" web "$results/vitest.json"
  fi
}

run_browser_tests() {
  local results=$1 filter=$2 program
  [[ e2e =~ $filter ]] || return 0
  if [ ! -e tests/web/run.mjs ]; then
    record_step "$results" skipped e2e "tests/web/run.mjs is not in this tree"
    return 0
  fi
  if ! command -v chromium-headless-shell >/dev/null && ! command -v chromium >/dev/null; then
    record_step "$results" skipped e2e "no chromium on this machine"
    return 0
  fi
  if ! have_node; then
    record_step "$results" skipped e2e "$(no_node_reason)"
    return 0
  fi
  for program in hoist-sim hoist-control hoist-server; do
    if [ ! -x "build/bin/$program" ]; then
      record_step "$results" skipped e2e "build/bin/$program is not in this tree"
      return 0
    fi
  done
  say "running the browser tests (tests/web)"
  node tests/web/run.mjs --json "$results/e2e.json" </dev/null || ended_badly "$results" e2e "$results/e2e.json"
}

# begin_beside LOG COMMAND...: runs it beside what follows; end_beside waits for it, shows its output and gives its status.
begin_beside() {
  beside_log=$1
  shift
  "$@" >"$beside_log" 2>&1 &
  beside=$!
  # A background job of a script does not get Ctrl-C from the terminal, and outlives a script that gives up.
  trap 'pkill -P "$beside"; kill "$beside"' EXIT
  trap 'exit 130' INT TERM
}
end_beside() {
  local status=0
  wait "$beside" || status=$?
  trap - EXIT INT TERM
  cat "$beside_log" >&2
  return "$status"
}

# give_way NICENESS: what waits, above all a hoist that a browser drives, loses its time to what computes at the same priority. A user who runs at a
# lower priority already may not raise it: that is fine as well.
give_way() { renice -n "$1" "$BASHPID" >/dev/null 2>&1 || true; }

# The longest two suites that walk in real time, or all of ctest, are over.
real_time_over() { [ -e "$1/ctest.ended" ] || { [ -e "$1/gtest/vcan_core.xml" ] && [ -e "$1/gtest/system_processes.xml" ]; }; }

# run_console_suites RESULTS FILTER: the browser tests and the console's unit tests beside each other, but not beside the suites that walk in real
# time: both drive browsers, each a session of its own, and the kernel shares the processors among sessions before it looks at priorities.
run_console_suites() {
  local results=$1 filter=$2 unit
  until real_time_over "$results"; do sleep 1; done
  (give_way 15 && run_web_tests "$results" "$filter") >"$results/unit.log" 2>&1 &
  unit=$!
  run_browser_tests "$results" "$filter"
  wait "$unit" || record_step "$results" failed web "the console's unit tests ended badly"
  cat "$results/unit.log"
}
# run_suites RESULTS FILTER: every suite of the normal build.
run_suites() {
  local results=$1 filter=$2
  begin_beside "$results/web.log" run_console_suites "$results" "$filter"
  run_ctest build "$results" "$filter"
  end_beside || record_step "$results" failed web "the tests of the console ended badly"
}

# tally RESULTS...: names failures and skips, prints the closing line, and is the verb's exit code.
tally() { node deploy/lib/tally.mjs "$@"; }
