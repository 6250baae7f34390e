#!/usr/bin/env bash
# ./scripts/test.sh [--all | --rest | --long]
# Installs what is missing, builds the program as users run it, and runs every test that needs no large package.
#   --all   adds what --rest runs
#   --rest  runs what the plain command leaves out: the ledger of costs, what is dear and rarely breaks, the tests that
#           need a browser, PyTorch, Slurm or a container, the CUDA backend's build where there is a compiler for it, the
#           address, undefined-behaviour and thread sanitizers, and each fuzzer for 10 s
#   --long  adds to --all what takes hours: full-size comparisons, every test under the sanitizers, 200 kills, valgrind,
#           the long run of the fuzzers, and a build of each file by itself
set -euo pipefail

parts=(plain)
case "${1:-}" in
  "") ;;
  --all) parts=(plain rest) ;;
  --rest) parts=(rest) ;;
  --long) parts=(plain rest long) ;;
  *) sed -n '2,9s/^# //p' "$0" >&2; exit 2 ;;
esac
source "$(dirname "$0")/setup.sh"
cd "$root"
started=$SECONDS

# compile PRESET [TARGET...]: generate.sh configures without tests. Warnings are errors in continuous integration alone,
# since a newer compiler has new ones.
compile() {
  local preset=$1 log=build/$1.log
  echo "== building $preset" >&2
  mkdir -p build
  cmake --preset "$preset" -DENSONIFY_TESTS=ON ${CI:+-DCMAKE_COMPILE_WARNING_AS_ERROR=ON} \
    "${configure_options[@]}" >"$log" || { cat "$log"; return 1; }
  cmake --build --preset "$preset" ${2:+--target "${@:2}"} >"$log" || { cat "$log"; return 1; }
}

# run PRESET CTEST-ARGUMENT...
run() {
  local preset=$1 status=0
  shift
  echo "== testing $preset" >&2
  ctest --preset "$preset" -j "$(nproc)" --output-junit results.xml "$@" || status=1
  echo "The ten slowest tests of $preset:"
  sed -n 's/.*<testcase name="\([^"]*\)".* time="\([0-9.]*\)".*/\2 \1/p' "build/$preset/results.xml" |
    sort -rn | awk 'NR <= 10 {t = $1; $1 = ""; printf "%8.1f s %s\n", t, $0}'
  return $status
}

plain() {
  install_packages "${build_packages[@]}" "${test_packages[@]}"
  compile release
  run release -LE 'long|heavy|gpu'
}

rest() {
  install_packages "${build_packages[@]}" "${test_packages[@]}" "${heavy_packages[@]}" "${sanitizer_packages[@]}"
  install_browser
  # One architecture: none of this machine's tests runs on a device, and each takes as long to compile.
  command -v nvcc >/dev/null && configure_options=(-DENSONIFY_CUDA=ON -DCMAKE_CUDA_ARCHITECTURES=90-real)
  compile release
  configure_options=()
  run release -L 'heavy|gpu' -LE long
  compile asan-ubsan test_programs ensonify_fuzz
  run asan-ubsan -L fast -LE long
  ./scripts/fuzz.sh --seconds 10
  compile tsan test_programs
  run tsan -L fast -LE long
}

long() {
  compile debug
  run release -L long
  compile asan-ubsan
  run asan-ubsan -LE 'fast|heavy'
  compile tsan
  run tsan -LE 'fast|heavy'
  ./scripts/kill_test.sh
  ./scripts/valgrind.sh
  ./scripts/fuzz.sh
}

for part in "${parts[@]}"; do $part; done
echo "passed in $(((SECONDS - started) / 60)) min $(((SECONDS - started) % 60)) s: ${parts[*]}"
case "${parts[*]}" in
  plain) echo "Left out: tests that need a browser, PyTorch, Slurm or a container; sanitizers; fuzzers. --all runs them." ;;
esac
