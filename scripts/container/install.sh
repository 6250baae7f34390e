#!/usr/bin/env bash
# ./scripts/container/install.sh [PREFIX]
# For recipes of containers, which run it as root: installs what is missing, builds without tests,
# and puts the program with scenes, sweeps and documentation in PREFIX (default: /usr/local).
set -euo pipefail

prefix=${1:-/usr/local}
source "$(dirname "$0")/../setup.sh"
install_packages "${build_packages[@]}"
configure_options=(-DENSONIFY_TESTS=OFF -DENSONIFY_CUDA=OFF)
build release ensonify >&2
# The importer belongs beside the program.
install -D -m 755 -t "$prefix/bin" "$root/build/release/ensonify" "$root/build/release/ensonify_import"
mkdir -p "$prefix/share/ensonify"
cp -r "$root"/{scenes,configs,docs} "$prefix/share/ensonify/"
"$prefix/bin/ensonify" --version
