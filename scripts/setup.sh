# Sourced by generate.sh and test.sh: packages and builds. Needs bash; root or sudo only where a
# package is missing.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

build_packages=(
  g++ cmake ninja-build pkg-config
  libembree-dev libtbb-dev libopenexr-dev libfftw3-dev libyaml-cpp-dev libassimp-dev
  libopenvdb-dev libboost-dev  # Boost: headers of OpenVDB include it, its package does not ask for it
  libcli11-dev libfmt-dev nlohmann-json3-dev libvalijson-dev libisal-dev libqhull-dev libpng-dev libjpeg-dev liblz4-dev libzstd-dev libssl-dev
  libarchive-dev libhdf5-dev libmuparser-dev libcairo2-dev libwebp-dev libeigen3-dev
  pybind11-dev python3-dev
)
test_packages=(catch2 ccache python3-minimal python3-numpy python3-h5py python3-jsonschema python3-pil mypy)
# For the tests with the label `heavy`, which skip without them; the ledger's fails without valgrind. python3-torch takes
# 0.9 GB on disk with all that it depends on. The tests of clusters start a private Slurm of their own and leave this
# machine's services alone.
heavy_packages=(python3-torch python3-build python3-venv slurm-wlm munge parallel valgrind)
# The sanitizers and libFuzzer of Debian 12's default clang, and a linker that takes a seventh of the time.
sanitizer_packages=(clang libclang-rt-14-dev lld)

is_installed() {
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

# install_packages NAME...: those that are missing, saying which.
install_packages() {
  local missing=() as_root=() package
  for package in "$@"; do is_installed "$package" || missing+=("$package"); done
  [ ${#missing[@]} -eq 0 ] && return
  echo "installing Debian packages: ${missing[*]}" >&2
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
      echo "these packages need root or sudo to install; ask your administrator for them" >&2
      return 4
    fi
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# install_browser: Chromium, node and the modules that tests/report drives it with. Debian's node and npm do; its
# npm cannot be installed next to a nodejs package of NodeSource, so where both commands are there they stay,
# and those in /usr/bin come first.
install_browser() {
  local packages=(chromium)
  command -v node >/dev/null && command -v npm >/dev/null || packages+=(nodejs npm)
  install_packages "${packages[@]}"
  local folder=$root/tests/report
  [ "$folder/node_modules/.package-lock.json" -nt "$folder/package-lock.json" ] && return
  echo "installing node modules into tests/report/node_modules" >&2
  (cd "$folder" && PATH=/usr/bin:$PATH npm ci --no-audit --no-fund --ignore-scripts >/dev/null) ||
    echo "npm could not fetch them: the tests of pages in a browser are skipped" >&2
}

# build PRESET [TARGET...]: configures once, then builds what changed.
build() {
  local preset=$1
  shift
  cd "$root"
  if [ ! -f "build/$preset/build.ninja" ]; then
    cmake --preset "$preset" ${ENSONIFY_CUDA:+-DENSONIFY_CUDA="$ENSONIFY_CUDA"} "${configure_options[@]}" \
      >"build-$preset.log" 2>&1 || {
      cat "build-$preset.log" >&2
      return 1
    }
    rm -f "build-$preset.log"
  fi
  cmake --build --preset "$preset" ${1:+--target "$@"}
}
configure_options=()
