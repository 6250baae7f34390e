#!/usr/bin/env bash
# install.sh
# The second stage of both container recipes, which run it as root: installs the package next to it
# without python3 and other recommended packages, and removes what an image does not need.
set -euo pipefail

folder=$(cd "$(dirname "$0")" && pwd)
apt-get update -qq
apt-get install -y -qq --no-install-recommends "$folder"/ensonify_*.deb
rm -rf /var/lib/apt/lists/* "$folder"
ensonify --version
