# shellcheck shell=bash
# random sessions with random faults in virtual time; invariants are checked in every step
#
# options: --sessions N, --seed S, --length SECONDS, --no-faults, --loss SHARE, --jitter SECONDS, --unmoved, --faults LIST, --story, --hashes,
#          --state FILE, --jobs N (hoist-chaos --help says what they mean)
#          --masks       instead, each monitor of the core switched off in turn: how many sessions the judge needs to find it
#                        (--sessions N at most for each, --seed S, --monitor NAME, --jobs N)
#          --mutants     instead, 60 planted errors (tests/chaos/planted.tsv): how many sessions the judge needs to find each; fails when one
#                        survives (--sessions N at most for each, --first N, --only NUMBER,NUMBER, --jobs N)
#          --drawn       the same with 60 single changes to core and nodes, drawn by a seed: a share, no verdict
#                        (--count N, --seed TEXT)
#          --compilers   a few sessions built four ways (g++ and clang++, with and without optimisation): every second's hash must be the same
#          --no-setup    leave the machine as it is
# A failing session is reported with its seed and reduced; the printed line replays it:
# `deploy/dev chaos --seed S --length L --faults LIST`. Such lines are kept in tests/chaos/kept_seeds.txt and run by every test.
# A long run can be resumed: `deploy/dev chaos --sessions 100000 --state FILE` continues.
arguments=()
compilers=
masks=
mutants=
drawn=
for option in "$@"; do
  case $option in
    --no-setup | -h | --help) common_option chaos "$option" ;;
    --compilers) compilers=1 ;;
    --masks) masks=1 ;;
    --mutants) mutants=1 ;;
    --drawn) drawn=1 ;;
    *) arguments+=("$option") ;;
  esac
done

# The same sessions by every compiler: any difference is an error of the product or of the session.
compare_compilers() {
  local reference='' name compiler kind flags folder told hashes failed=0
  for name in g++-release g++-debug clang++-release clang++-debug; do
    compiler=${name%-*} kind=${name#*-} flags=-O2
    [[ $kind == debug ]] && flags=-O0
    if [[ $compiler == clang++ ]]; then compiler=$(command -v clang++ clang++-19 clang++-14 | head -n 1 || true); fi
    if [[ -z $compiler ]]; then
      echo "$name: skipped, there is no clang++ here"
      continue
    fi
    folder=build/chaos-$name
    say "building with $name ($folder/)"
    build_tree "$folder" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=None "-DCMAKE_CXX_FLAGS=$flags -w -DNDEBUG" -- hoist-chaos ||
      die "the build with $name failed: see above"
    told=$("$folder/bin/hoist-chaos" --sessions 4 --seed 11 --length 60 --hashes --quiet --jobs 1) || {
      grep -v '^seed' <<<"$told" || true
      die "$name: a session broke a promise, or the program failed"
    }
    hashes=$(grep '^seed' <<<"$told" | sha256sum | cut -c 1-16)
    echo "$name: $hashes"
    reference=${reference:-$hashes}
    [[ $hashes == "$reference" ]] || failed=1
  done
  if ((failed)); then echo "the builds differ: compare their --hashes second by second"; else echo "the same in every second"; fi
  return "$failed"
}

setup build
if [[ -n $compilers ]]; then
  compare_compilers
  exit
fi
if [[ -n $masks ]]; then
  build_normal hoist-chaos-masks
  exec build/bin/hoist-chaos-masks "${arguments[@]}"
fi
if [[ -n $drawn ]]; then
  setup check  # the reader of the sources
  build_normal chaos_mutants
  exec tests/chaos/mutants.py build/bin/chaos_mutants build/tests/mutants/chaos_mutants/mutants.tsv tests/mutants/known.tsv "${arguments[@]}"
fi
if [[ -n $mutants ]]; then
  setup test  # python3
  build_normal chaos_planted
  exec tests/chaos/mutants.py build/bin/chaos_planted build/tests/mutants/chaos_planted/mutants.tsv "${arguments[@]}"
fi
build_normal hoist-chaos
exec build/bin/hoist-chaos "${arguments[@]}"
