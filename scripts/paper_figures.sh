#!/usr/bin/env bash
# ./scripts/paper_figures.sh [--keep-times]
# From a bare Debian 12 to docs/paper.md and its figures: installs what is missing, builds the release
# preset, makes figures 7 to 11 and both tables of the paper and holds them against what it says.
# --keep-times leaves the run times that the page has, which need a machine with nothing else to do.
set -euo pipefail

if [ $# -gt 1 ] || { [ $# -eq 1 ] && [ "$1" != --keep-times ]; }; then
  sed -n '2,5s/^# //p' "$0" >&2
  exit 2
fi
source "$(dirname "$0")/setup.sh"
install_packages "${build_packages[@]}" python3-minimal python3-numpy python3-matplotlib
configure_options=(-DENSONIFY_TESTS=OFF)
build release ensonify >&2
cd "$root"
/usr/bin/python3 tests/verification/paper_figures.py build/release/ensonify \
  --page docs/paper.md --figures docs/figures "$@"
echo "page: docs/paper.md"
