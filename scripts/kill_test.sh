#!/usr/bin/env bash
# ./scripts/kill_test.sh [KILLS]
# Kills a run, a rig and a sweep at random moments (200 each where no number is given), starts them again, and
# compares every byte with an undisturbed run. A failure tells the seed of its moments: KILL_SEED=N
# ./scripts/kill_test.sh tries the same again.
set -euo pipefail

case "${1:-200}" in
  *[!0-9]*) sed -n '2,5s/^# //p' "$0" >&2; exit 2 ;;
esac
source "$(dirname "$0")/setup.sh"
install_packages "${build_packages[@]}" python3-minimal
build release ensonify >&2
cd "$root/tests/abuse"
ENSONIFY=${ENSONIFY:-$root/build/release/ensonify} KILLS=${1:-200} exec /usr/bin/python3 -m unittest -v kill_test
