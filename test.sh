#!/usr/bin/env bash
# Checks the format of the sources, builds Gelenk and runs every test: the release build, the core without graphics, and all of
# it, the window and its monkey and the Python module included, under ASan and UBSan; the Python module.
#   ./test.sh            all of it
#   ./test.sh release    one part: format, release, core, sanitize or python
#   ./test.sh short      a part of "sanitize": the window, its monkey and bad input, nothing else built; what .ci/run takes of it
#   ./test.sh web        the page in a browser (docs/web.md); not part of "all of it", since its compiler takes 0.8 GB
set -euo pipefail
cd "$(dirname "$0")"
./install_packages.sh test
export LIBGL_ALWAYS_SOFTWARE=1 EGL_PLATFORM=surfaceless
export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1
parts=("$@")
[ ${#parts[@]} -gt 0 ] || parts=(format release core sanitize python)
for part in "${parts[@]}"; do
  echo "== $part"
  if [ "$part" = format ]; then
    find kinematics solvers skinning apps tests -name '*.cpp' -o -name '*.h' | xargs -P "$(nproc)" -n 40 clang-format --dry-run -Werror
    continue
  fi
  if [ "$part" = python ]; then  # Debian's interpreter, which sees Debian's numpy and pytest
    cmake --preset release -DGELENK_PYTHON=ON -DPython3_EXECUTABLE=/usr/bin/python3 >/dev/null
    cmake --build --preset release --target _gelenk gelenk
    ctest --preset release -R '^Python'
    continue
  fi
  if [ "$part" = web ]; then
    ./install_packages.sh webtest
    ./web.sh
    NODE_PATH=/usr/share/nodejs cmake --build --preset web --target all core_tests
    tests/web/core_test.py build-web/apps/web
    cmake --preset release >/dev/null
    cmake --build --preset release --target gelenk web_speed
    tests/web/figures_test.py build-web/apps/web/figures.js build/gelenk
    tests/web/speed_test.py build-web/apps/web/speed.js build/tests/web_speed
    tests/web/page_test.py build-web/site build/gelenk
    continue
  fi
  preset=$part options=() targets=() tests=()
  if [ "$part" = sanitize ]; then options=(-DGELENK_PYTHON=ON -DPython3_EXECUTABLE=/usr/bin/python3); fi  # wrong calls from Python too
  if [ "$part" = short ]; then
    preset=sanitize targets=(--target sandbox_tests) tests=(-R '^(Seeds/Monkey|Monkey|RealWindow|BadInput|BindingPanel|MusclePanel|Unsaved|RigPanel)')
  fi
  cmake --preset "$preset" "${options[@]}" >/dev/null
  cmake --build --preset "$preset" "${targets[@]}"
  ctest --preset "$preset" -j "$(nproc)" "${tests[@]}"
done
