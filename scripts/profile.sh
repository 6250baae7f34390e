#!/usr/bin/env bash
# ./scripts/profile.sh SCENARIO [KEY.PATH=VALUE...]
# Where the time of a data set of the scenario goes: by stage (ensonify bench), then by function
# where perf is installed (Debian: linux-perf). Builds the release preset; one thread, 24 pings.
set -euo pipefail

if [ $# -eq 0 ] || [ "${1#-}" != "$1" ]; then
  sed -n '2,4s/^# //p' "$0" >&2
  exit 2
fi
source "$(dirname "$0")/setup.sh"
scenario=$(realpath "$1")
shift
sets=()
for set in "$@"; do sets+=(--set "$set"); done
[ -x "$root/build/release/ensonify" ] || build release ensonify >&2

ensonify=("$root/build/release/ensonify" bench "$scenario" "${sets[@]}" --threads 1 --pings 24)
"${ensonify[@]}" 2>/dev/null
if ! command -v perf >/dev/null; then
  echo "no profile by function: perf is not installed (apt-get install linux-perf)"
  exit
fi
data=$(mktemp)
trap 'rm -f "$data" "$data.old"' EXIT
perf record --quiet --freq 499 --output "$data" "${ensonify[@]}" >/dev/null 2>&1
echo
echo "share of the processor's time by library, then by function:"
perf report --input "$data" --stdio --no-children --sort dso 2>/dev/null | grep -v '^#' | grep -v '^$' | head -12
perf report --input "$data" --stdio --no-children --sort symbol 2>/dev/null | grep -v '^#' | grep -v '^$' |
  cut -c1-150 | head -40
