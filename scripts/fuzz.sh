#!/usr/bin/env bash
# ./scripts/fuzz.sh [--seconds N] [FUZZER...]
# Gives readers of foreign text and files what nobody would write, by libFuzzer under the address and
# undefined-behaviour sanitizers, and reports what was tried and found. Without --seconds until
# 1,000,000 inputs went through the scenario parser and 100,000 through each other reader.
# FUZZER: scenario override sweep mesh grid table npy dataset recording; all where none is named.
# A finding is a crash, more than ten seconds for one input, more than 1 GB of memory, or a leak; its
# input is kept in build/asan-ubsan/fuzz/findings, and the script ends with 1.
set -euo pipefail

seconds=0
fuzzers=()
while [ $# -gt 0 ]; do
  case "$1" in
    --seconds) seconds=${2:?--seconds needs a number}; shift ;;
    -*) sed -n '2,9s/^# //p' "$0" >&2; exit 2 ;;
    *) fuzzers+=("$1") ;;
  esac
  shift
done
source "$(dirname "$0")/setup.sh"
[ ${#fuzzers[@]} -gt 0 ] || fuzzers=(scenario override sweep mesh grid table npy dataset recording)
install_packages "${build_packages[@]}" "${sanitizer_packages[@]}" python3-numpy
cd "$root"
build release ensonify >&2
build asan-ubsan ensonify_fuzz >&2

sanitized=$root/build/asan-ubsan
here=$sanitized/fuzz
mkdir -p "$here/findings" "$here/corpus" "$here/logs"
/usr/bin/python3 tests/fuzz/make_seeds.py "$root/build/release/ensonify" "$here/seeds"
# Readers of files read them from memory.
scratch=$(mktemp -d "$([ -w /dev/shm ] && echo /dev/shm || echo "${TMPDIR:-/tmp}")/ensonify-fuzz.XXXXXX")
trap 'rm -rf "$scratch"' EXIT

runs_of() { [ "$1" = scenario ] && echo 1000000 || echo 100000; }

fuzz() { # FUZZER
  local name=$1 limit=(-max_total_time="$seconds")
  [ "$seconds" -gt 0 ] || limit=(-runs="$(runs_of "$name")")
  mkdir -p "$here/corpus/$name"
  TMPDIR=$scratch "$sanitized/tests/fuzz/fuzz_$name" "${limit[@]}" -timeout=10 -rss_limit_mb=1024 \
    -print_final_stats=1 -artifact_prefix="$here/findings/$name-" \
    "$here/corpus/$name" "$here/seeds/$name" >"$here/logs/$name" 2>&1
}

stat_of() { # LOG WORD
  sed -n "s/^$2: *//p" "$1" | tail -1
}

report() { # FUZZER STATUS
  local log=$here/logs/$1 found=none
  [ "$2" = 0 ] || found=$(grep -o 'Test unit written to .*' "$log" | sed 's/.* //' || echo "see $log")
  printf '%-9s %10s %8s/s %9s %7s MB  %s\n' "$1" "$(stat_of "$log" stat::number_of_executed_units)" \
    "$(stat_of "$log" stat::average_exec_per_sec)" "$(stat_of "$log" accepted)" \
    "$(stat_of "$log" stat::peak_rss_mb)" "$found"
  # What an automatic check prints is all that is left of its build folder.
  [ "$2" = 0 ] || awk '/^Base64|runtime error/ { print; next } /ERROR/ { left = 30 } left-- > 0' "$log"
}

printf '%-9s %10s %10s %9s %10s  %s\n' reader inputs speed accepted memory findings
failed=0
for ((i = 0; i < ${#fuzzers[@]}; i += $(nproc))); do
  at_once=("${fuzzers[@]:i:$(nproc)}")
  jobs=()
  for name in "${at_once[@]}"; do fuzz "$name" & jobs+=($!); done
  for ((j = 0; j < ${#at_once[@]}; ++j)); do
    status=0
    wait "${jobs[j]}" || status=1
    # One that accepts nothing is not looking behind the first check.
    [ "$(stat_of "$here/logs/${at_once[j]}" accepted)" ] || status=1
    report "${at_once[j]}" $status
    failed=$((failed | status))
  done
done
exit $failed
