#!/usr/bin/env bash
# ./scripts/package.sh [FOLDER]
# Builds the Debian packages in FOLDER (default: build/package) and prints their paths: installs what is
# missing, builds build/release/ensonify, packs: ensonify, python3-ensonify and, with a CUDA device or
# ENSONIFY_CUDA=ON, ensonify-cuda. What they hold: scripts/cmake/EnsonifyInstall.cmake.
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
