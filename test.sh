#!/usr/bin/env bash
# Checks the format of the sources, builds Gelenk and runs every test: the release build, the core without graphics, and all of
# it, the window and its monkey included, under ASan and UBSan.
#   ./test.sh            all of it
#   ./test.sh release    one part: format, release, core or sanitize
set -euo pipefail
cd "$(dirname "$0")"
./install_packages.sh test
export LIBGL_ALWAYS_SOFTWARE=1 EGL_PLATFORM=surfaceless
export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1
parts=("$@")
[ ${#parts[@]} -gt 0 ] || parts=(format release core sanitize)
for part in "${parts[@]}"; do
  echo "== $part"
  if [ "$part" = format ]; then
    find kinematics solvers skinning apps tests -name '*.cpp' -o -name '*.h' | xargs -P "$(nproc)" -n 40 clang-format --dry-run -Werror
    continue
  fi
  cmake --preset "$part" >/dev/null
  cmake --build --preset "$part"
  ctest --preset "$part" -j "$(nproc)"
done
