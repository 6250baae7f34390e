#!/usr/bin/env bash
# ./scripts/verify_physics.sh
# From a bare Debian 12 to docs/verification.md and docs/figures: installs what is missing, builds
# the release preset, runs every experiment and writes what it expected and what it obtained.
set -euo pipefail

if [ $# -gt 0 ]; then
  sed -n '2,4s/^# //p' "$0" >&2
  exit 2
fi
source "$(dirname "$0")/setup.sh"
install_packages "${build_packages[@]}" python3-minimal python3-numpy python3-matplotlib
configure_options=(-DENSONIFY_TESTS=OFF)
build release ensonify >&2
cd "$root"
/usr/bin/python3 tests/verification/verify_physics.py build/release/ensonify \
  --report docs/verification.md --figures docs/figures
echo "report: docs/verification.md"
