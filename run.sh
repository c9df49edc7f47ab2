#!/usr/bin/env bash
# Builds Gelenk and opens the sandbox. Arguments go to the program: ./run.sh lecture, ./run.sh sandbox BODY.obj ...
set -euo pipefail
cd "$(dirname "$0")"
./install_packages.sh run
[ -e build/build.ninja ] || cmake --preset release -DGELENK_TESTS=OFF -DGELENK_BENCHMARKS=OFF >/dev/null
cmake --build build --target gelenk
exec build/gelenk "${@:-sandbox}"
