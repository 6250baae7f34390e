#!/usr/bin/env bash
# ./scripts/package.sh [FOLDER]
# Builds the Debian package in FOLDER (default: build/package) and prints its path: installs what is
# missing, builds build/release/ensonify, packs. With a CUDA device, or with ENSONIFY_CUDA=ON,
# ensonify-cuda is the second package. What they hold: scripts/cmake/EnsonifyInstall.cmake.
set -euo pipefail

if [ $# -gt 1 ] || [[ "${1:-}" == -* ]]; then
  sed -n '2,5s/^# //p' "$0" >&2
  exit 2
fi
source "$(dirname "$0")/setup.sh"
folder=$(realpath -m -- "${1:-$root/build/package}")

install_packages "${build_packages[@]}" dpkg-dev file
configure_options=(-DENSONIFY_TESTS=OFF)
build release ensonify >&2
rm -f "$folder"/ensonify*.deb
cpack --config "$root/build/release/CPackConfig.cmake" -B "$folder" >&2
rm -rf "$folder/_CPack_Packages"
ls "$folder"/ensonify*.deb
