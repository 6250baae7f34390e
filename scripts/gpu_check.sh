#!/usr/bin/env bash
# ./scripts/gpu_check.sh [carry]
# On a machine with a CUDA device, a CUDA toolkit (12 or newer), CMake, and Python with numpy: builds the cuda preset and
# the program, runs the tests, compute-sanitizer and the benchmark, compares scenes, ensembles, streams and whole data sets
# with the processor (gpu_check.py), and writes build/gpu_check.json. It takes less than ten minutes with 16 cores, and
# ends with 0 if all tests pass and every figure is as good as wanted.
#   carry   on a machine with Debian's packages: puts what the other may lack into build/carried, to be copied there with
#           this folder: Catch2, FFTW, and the built program with its libraries
set -euo pipefail
cd "$(dirname "$0")/.."
carried=$PWD/build/carried

# The shared libraries that these files need, and the loader of programs, but for those of CUDA.
libraries() {
  ldd "$@" | grep -oE '\s/\S+\.so\S*' | grep -vE ':$|libcu(da|dart|fft)' | sort -u
}

carry() {
  rm -rf "$carried"
  mkdir -p "$carried/include" "$carried/lib"
  cp -r /usr/include/catch2 "$carried/include/"
  cp /usr/include/fftw3.h "$carried/include/"
  cp "$(dpkg -L libfftw3-dev | grep '/libfftw3\.a$')" "$carried/lib/"
  if [ -e build/release/libensonify_cuda.so ]; then
    carry_program "$carried/program" build/release/{ensonify,ensonify_import,libensonify_cuda.so}
  else
    echo "without the program: build the preset release with -DENSONIFY_CUDA=ON first" >&2
  fi
  du -sh "$carried"
}

# carry_program FOLDER FILE...: an archive of the program. Each is started by the loader of its own C library, which may be
# newer than that of the other machine.
carry_program() {
  local folder=$1 name
  mkdir -p "$folder/parts" "$folder/lib"
  cp "${@:2}" "$folder/parts/"
  strip "$folder"/parts/*
  libraries "${@:2}" | xargs cp -Lt "$folder/lib"
  for name in ensonify ensonify_import; do
    cat >"$folder/$name" <<END
#!/bin/sh
here=\$(cd "\$(dirname "\$0")" && pwd)
export ENSONIFY_COMPANIONS="\$here"
exec "\$here"/lib/ld-linux-* --library-path "\$here/lib:\$LD_LIBRARY_PATH" "\$here/parts/$name" "\$@"
END
    chmod +x "$folder/$name"
  done
  ln -s parts/libensonify_cuda.so "$folder/"
  tar -C "$carried" -czf "$folder.tar.gz" program
  rm -r "$folder"
}

# step COMMAND...: prints the seconds so far, and what the command printed if it fails.
step() {
  echo "== ${SECONDS} s: $*" >&2
  "$@" >build/gpu_check.log 2>&1 || {
    local status=$?
    cat build/gpu_check.log >&2
    return $status
  }
}

# The program with its CUDA module: what was carried here, or else built. Without it the figures of the benchmark remain.
program=build/cuda-program/ensonify
make_program() {
  if [ -e "$carried/program.tar.gz" ]; then
    program=$carried/program/ensonify
    step tar -C "$carried" -xzf "$carried/program.tar.gz"
  else
    step cmake --preset release -B build/cuda-program -G "$generator" -DENSONIFY_CUDA=ON -DENSONIFY_TESTS=OFF "${native[@]}" &&
      step cmake --build build/cuda-program -j "$(nproc)"
  fi
}

if [ "${1:-}" = carry ]; then
  carry
  exit
fi
[ $# -eq 0 ] || { sed -n '2,9s/^# //p' "$0" >&2; exit 2; }
for python in python3 /usr/bin/python3; do
  "$python" -c "import numpy" 2>/dev/null && break
done || { echo "there is no python3 with numpy" >&2; exit 1; }
generator=$(command -v ninja >/dev/null && echo Ninja || echo "Unix Makefiles")
nvcc=$(command -v nvcc || echo /usr/local/cuda/bin/nvcc)
toolkit=$(dirname "$(dirname "$nvcc")")
export PATH=$toolkit/bin:$PATH LD_LIBRARY_PATH=$toolkit/lib64:${LD_LIBRARY_PATH:-}
native=()
if nvidia-smi -L >/dev/null 2>&1; then native=(-DCMAKE_CUDA_ARCHITECTURES=native); fi
mkdir -p build
failed=0
step cmake --preset cuda -G "$generator" "-DENSONIFY_CARRIED=$([ -d "$carried" ] && echo "$carried")" "${native[@]}"
step cmake --build build/cuda -j "$(nproc)" --target all ensonify_gpu_bench
step ctest --test-dir build/cuda -LE long -j "$(nproc)" --output-on-failure || failed=1
grep 'tests passed' build/gpu_check.log || failed=1
if ! build/cuda/ensonify_gpu_bench | tee build/cuda/bench.txt; then
  echo "there is no device, or the benchmark failed" >&2
  exit 5
fi
if command -v compute-sanitizer >/dev/null; then
  for tool in memcheck racecheck; do
    ENSONIFY_CUDA_MODULE=$PWD/build/cuda/libensonify_cuda.so step timeout 90 compute-sanitizer --tool "$tool" \
      --error-exitcode 1 build/cuda/tests/synthesis/test_gpu ||
      { [ $? -eq 124 ] && echo "not finished after 90 s" >&2; } || failed=1
    tail -1 build/gpu_check.log
  done
fi
make_program || failed=1
"$python" scripts/gpu_check.py --program "$program" --bench build/cuda/bench.txt --json build/gpu_check.json || failed=1
echo "build/gpu_check.json after ${SECONDS} s; scripts/make_performance.py fills docs/performance.md from it" >&2
exit $failed
