#!/usr/bin/env bash
# ./scripts/valgrind.sh
# Makes a ping of two small scenes under valgrind, one with a mesh, and so with its importer: no read of
# what was never written, none outside of what was allocated, nothing lost. Nothing is suppressed.
set -euo pipefail

[ $# -eq 0 ] || { sed -n '2,4s/^# //p' "$0" >&2; exit 2; }
source "$(dirname "$0")/setup.sh"
install_packages "${build_packages[@]}" valgrind
build release ensonify >&2
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for scene in sonar_tank wreck_survey; do
  # AVX-512 is beyond valgrind.
  valgrind -q --trace-children=yes --error-exitcode=9 \
    --leak-check=full --show-leak-kinds=definite --errors-for-leak-kinds=definite \
    "$root/build/release/ensonify" generate "$root/scenes/$scene.yaml" -o "$out/$scene" --quiet --pings 0:1 \
    --threads 2 --set 'sonar.beams={count: 16, fov_deg: 40}' --set 'sonar.rays={elevation: 8, min_per_cell: 8}' \
    --set sequences=1
  "$root/build/release/ensonify" verify "$out/$scene"
done
