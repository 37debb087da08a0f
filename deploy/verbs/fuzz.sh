# shellcheck shell=bash
# attacks every decoder with mutated input, guided by coverage, under sanitizers
#
# options: --seconds N   for each target (default 60)
#          --only NAME   one target; without it all of tests/fuzz/targets.def
#          --no-setup    leave the machine as it is
# Failing inputs are kept in build/fuzz/found/NAME; add them to tests/fuzz/corpus/NAME with the fix, as tests.
seconds=60
only=
while [ $# -gt 0 ]; do
  case $1 in
    --seconds)
      [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || die "--seconds needs a whole number above 0"
      seconds=$2
      shift
      ;;
    --only)
      [ -n "${2:-}" ] || die "--only needs the name of a target (tests/fuzz/targets.def)"
      only=$2
      shift
      ;;
    *) common_option fuzz "$1" ;;
  esac
  shift
done
setup build fuzz
command -v clang++ >/dev/null || die "there is no clang++ on this machine: libFuzzer is part of clang (packages clang and libclang-rt-*-dev)"

say "building the targets for libFuzzer (build/fuzz/)"
# Warnings are g++'s business; clang's differ from the ones the code is written for.
build_tree build/fuzz -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=None "-DCMAKE_CXX_FLAGS=-O1 -g1 -w -fsanitize=fuzzer-no-link" \
  -DHOIST_SANITIZE=address,undefined -DHOIST_BENCH=OFF -DHOIST_FUZZ=ON -- hoist-fuzz || die "the fuzz targets did not build: see above"

mapfile -t names < <(build/fuzz/bin/hoist-fuzz --list)
if [ -n "$only" ]; then
  printf '%s\n' "${names[@]}" | grep -qxF "$only" || die "there is no fuzz target '$only'; there are: ${names[*]}"
  names=("$only")
fi

# fuzz_one NAME SECONDS: prints one line; its exit code says whether the target held.
fuzz_one() {
  local name=$1 folder=build/fuzz log runs
  log=$folder/$name.log
  mkdir -p "$folder/seeds/$name" "$folder/found/$name" "$folder/inputs/$name"
  export HOIST_FUZZ_TARGET=$name UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
  "$folder/bin/hoist-fuzz" --seeds "$folder/seeds/$name"
  local folders=("$folder/inputs/$name" "$folder/seeds/$name")
  [ ! -d "tests/fuzz/corpus/$name" ] || folders+=("tests/fuzz/corpus/$name")
  if "$folder/bin/hoist-fuzz" -max_total_time="$2" -max_len=4096 -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
    -artifact_prefix="$folder/found/$name/" "${folders[@]}" >"$log" 2>&1; then
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    echo "passed  fuzz $name: $runs inputs in $2 s"
  else
    grep -vE '^#[0-9]+[[:space:]]+(NEW|REDUCE|pulse|INITED|RELOAD)' "$log" | tail -n 60
    echo "FAILED  fuzz $name: see build/fuzz/found/$name"
    return 1
  fi
}
export -f fuzz_one

say "fuzzing ${#names[@]} targets, $seconds s each, $(nproc) at a time"
failed=0
# shellcheck disable=SC2016 # the inner shell expands them
printf '%s\0' "${names[@]}" | xargs -0 -P "$(nproc)" -I {} bash -c 'fuzz_one "$1" "$2"' fuzz {} "$seconds" | tee build/fuzz/summary.txt || true
failed=$(grep -c '^FAILED' build/fuzz/summary.txt || true)
echo "$((${#names[@]} - failed)) passed, $failed failed, 0 skipped"
[ "$failed" = 0 ]
