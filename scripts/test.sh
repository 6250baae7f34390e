#!/usr/bin/env bash
# ./scripts/test.sh [--long]
# Installs what is missing, builds, and runs every test: the release build, the ground floor
# without the big libraries, the fast tests under the sanitizers, and each fuzzer for a minute. --long
# adds the full-size comparisons, which take minutes to hours, all tests under the sanitizers, 200 kills,
# valgrind and the long run of the fuzzers.
set -euo pipefail

long=no
case "${1:-}" in
  "") ;;
  --long) long=yes ;;
  *) sed -n '2,7s/^# //p' "$0" >&2; exit 2 ;;
esac
source "$(dirname "$0")/setup.sh"
install_packages "${build_packages[@]}" "${test_packages[@]}"
install_browser
cd "$root"

# generate.sh configures without tests.
configure() { cmake --preset "$1" -DENSONIFY_TESTS=ON >/dev/null; }
run() { # PRESET CTEST-ARGUMENT...
  local preset=$1
  shift
  echo "== $preset" >&2
  configure "$preset"
  build "$preset" >/dev/null || { build "$preset"; return 1; }
  ctest --preset "$preset" -j "$(nproc)" "$@"
}

without_long=(-LE long)
[ $long = yes ] && without_long=()
# Hundreds of pings of one and the same code add draws, not paths: not under sanitizers.
statistics='V4: |V5: mean power|V6: level inside'
run acoustics-only "${without_long[@]}"
sanitized=(-L fast -E "$statistics")
[ $long = yes ] && sanitized=(-LE long)
run asan-ubsan "${sanitized[@]}"
run tsan "${sanitized[@]}"
run release "${without_long[@]}"
if [ $long = yes ]; then
  ./scripts/kill_test.sh
  ./scripts/valgrind.sh
  ./scripts/fuzz.sh
else
  ./scripts/fuzz.sh --seconds 60
fi
