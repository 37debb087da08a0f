# shellcheck shell=bash
# format, lint, layer rules, generated files, sanitized builds, all tests: what CI runs
#
# Static checks count as one case each in the closing line `N passed, N failed, N skipped`.
# options: --no-setup   leave the machine as it is
# shellcheck source=deploy/lib/tests.sh
source deploy/lib/tests.sh
# shellcheck source=deploy/lib/lint.sh
source deploy/lib/lint.sh

common_options check "$@"
static=$(new_results static)
sanitized=$(new_results sanitize)
threads=$(new_results thread)
normal=$(new_results tests)

# timed NAME COMMAND...: how long each part takes is told at the end, so that one that grows is seen before CI's limit ends them all.
timed() {
  local name=$1 begun=$SECONDS status=0
  shift
  "$@" || status=$?
  printf '%6d s  %s\n' $((SECONDS - begun)) "$name" >>"$static/took.txt"
  return "$status"
}

timed "packages" setup build test firmware check

# step NAME COMMAND...: one static check; its output is shown when it fails.
step() {
  local name=$1 log=$static/step.log
  shift
  say "checking: $name"
  if timed "$name" "$@" >"$log" 2>&1; then
    record_step "$static" passed "$name"
  else
    cat "$log"
    record_step "$static" failed "$name" "see above"
  fi
}

if formatter=$(find_clang_format); then
  check_format() { cpp_files | xargs -0 -P "$(nproc)" -n 20 "$formatter" --dry-run -Werror; }
  step "format (deploy/dev format mends it)" check_format
else
  record_step "$static" skipped format "$(no_clang_format)"
fi
if command -v shellcheck >/dev/null; then
  check_shell() { shell_files | xargs -0 shellcheck -x; }
  step "shell scripts (shellcheck)" check_shell
else
  record_step "$static" skipped "shell scripts" "no shellcheck on this machine"
fi
step "line lengths" check_line_lengths
if have_node; then
  step "console: ESLint with types" check_console_code
  step "console: layout (deploy/dev format mends it)" check_console_layout
else
  record_step "$static" skipped "console: ESLint and Prettier" "$(no_node_reason)"
fi

timed "build" build_normal all proofs hoist-bench core_mutants
step "generated files (deploy/dev gen mends them)" build/bin/hoist-gen --top "$PWD" --check
if command -v clang-tidy >/dev/null; then
  step "clang-tidy" run_clang_tidy build
  # Report how far it came, also without findings.
  [ ! -e "$static/step.log" ] || tail -n 1 "$static/step.log"
else
  record_step "$static" skipped clang-tidy "no clang-tidy on this machine"
fi
build_web

# The tests of the normal build first: they find most, and soonest. With the long tests in full, a browser beside them starves the suites in real
# time; it does not mind what computes.
HOIST_THOROUGH=yes HOIST_PROOFS=yes timed "C++ tests" run_ctest build "$normal" .
begin_beside "$normal/web.log" timed "tests of the console" run_console_suites "$normal" .
(
  give_way 15
  timed "build with AddressSanitizer" build_sanitized all proofs || record_step "$static" failed "sanitized build" "see above"
  timed "build with ThreadSanitizer" build_thread_tests "$threads"
)
end_beside || record_step "$normal" failed web "the tests of the console ended badly"
# What ThreadSanitizer looks at waits more than it computes, and the suites with AddressSanitizer leave a third of the processors idle.
run_beside_sanitized() {
  local waits
  timed "ThreadSanitizer" run_thread_tests "$threads" >"$threads/ctest.log" 2>&1 &
  waits=$!
  give_way 19
  step "README: each way to add something, followed in a copy" python3 tests/recipes/recipes.py
  step "chaos: 400 random sessions (deploy/dev chaos replays one)" build/bin/hoist-chaos --sessions 400
  step "mutants: 60 drawn by the commit (deploy/dev cover --mutants tries all)" judge_mutants core_mutants --sample 60
  wait "$waits" || record_step "$threads" failed "ThreadSanitizer" "its tests ended badly"
  cat "$threads/ctest.log"
}
begin_beside "$static/beside.log" run_beside_sanitized
(
  give_way 10
  HOIST_PROOFS=yes timed "C++ tests with AddressSanitizer" run_ctest build/sanitize "$sanitized" .
)
end_beside || record_step "$static" failed "what runs beside AddressSanitizer" "ended badly"
say "it took:"
sort -rn "$static/took.txt" >&2
tally "$static" "$normal" "$sanitized" "$threads"
