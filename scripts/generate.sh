#!/usr/bin/env bash
# ./scripts/generate.sh [SCENARIO [OUTPUT_DIR]]
# From a bare Debian 12 or 13 to a data set: installs what is missing, builds, generates.
# Default: scenes/sonar_tank.yaml into out/sonar_tank. The CUDA backend is built where there is a device for it, or with
# ENSONIFY_CUDA=ON.
set -euo pipefail

if [ $# -gt 2 ] || [[ "${1:-}" == -* ]]; then
  sed -n '2,5s/^# //p' "$0" >&2
  exit 2
fi
source "$(dirname "$0")/setup.sh"
# Paths are the caller's, who may stand anywhere.
scenario=$(realpath -m -- "${1:-$root/scenes/sonar_tank.yaml}")
output=$(realpath -m -- "${2:-$root/out/$(basename "${scenario%.*}")}")

install_packages "${build_packages[@]}"
configure_options=(-DENSONIFY_TESTS=OFF)
build release ensonify >&2
"$root/build/release/ensonify" generate "$scenario" -o "$output"
pictures=$output/sequences/000000/png
[ -d "$pictures" ] || pictures="none were asked for"
echo "pictures: $pictures; every file is explained in $output/README.md"
