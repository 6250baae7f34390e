#!/usr/bin/env bash
# ./scripts/gpu_check.sh [carry]
# On a machine with a CUDA device, a CUDA toolkit and CMake: builds the cuda preset, runs every test
# and the benchmark, and prints one table. What such a machine lacks, Catch2 and FFTW, comes along in
# build/carried: `gpu_check.sh carry` puts it there on a machine that has Debian's packages.
set -euo pipefail
cd "$(dirname "$0")/.."
carried=$PWD/build/carried

if [ "${1:-}" = carry ]; then
  rm -rf "$carried"
  mkdir -p "$carried/include" "$carried/lib"
  cp -r /usr/include/catch2 "$carried/include/"
  cp /usr/include/fftw3.h "$carried/include/"
  cp "$(dpkg -L libfftw3-dev | grep '/libfftw3\.a$')" "$carried/lib/"
  echo "carried: $(du -sh "$carried" | cut -f1) in build/carried"
  exit 0
fi
[ $# -eq 0 ] || { sed -n '2,5s/^# //p' "$0" >&2; exit 2; }
generator=$(command -v ninja >/dev/null && echo Ninja || echo "Unix Makefiles")
cmake --preset cuda -G "$generator" \
  "-DENSONIFY_CARRIED=$([ -d "$carried" ] && echo "$carried")" >build-cuda.log 2>&1 ||
  { cat build-cuda.log >&2; exit 1; }
rm -f build-cuda.log
cmake --build build/cuda -j "$(nproc)" --target all ensonify_gpu_bench
(cd build/cuda && ctest -LE long -j "$(nproc)" --output-on-failure | grep -vE '^ *(Start|[0-9]+/[0-9]+ .*Passed)')
if ! build/cuda/ensonify_gpu_bench >build/cuda/bench.txt; then
  cat build/cuda/bench.txt
  grep -q '^skipped: ' build/cuda/bench.txt || exit 1
  exit 0
fi
cat build/cuda/bench.txt
if command -v compute-sanitizer >/dev/null; then
  for tool in memcheck racecheck; do
    echo "== compute-sanitizer $tool"
    ENSONIFY_CUDA_MODULE=$PWD/build/cuda/libensonify_cuda.so \
      compute-sanitizer --tool "$tool" --error-exitcode 1 build/cuda/tests/synthesis/test_gpu | tail -3
  done
fi
