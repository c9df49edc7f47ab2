#!/usr/bin/env bash
# Builds Gelenk and opens the sandbox. Arguments go to the program: ./run.sh lecture, ./run.sh sandbox BODY.obj ...
# Without a display the sandbox's scene is rendered offscreen instead: a scripted drag, a picture and a status file in out/.
set -euo pipefail
cd "$(dirname "$0")"
[ -x build/gelenk ] || echo "First start: installs what is missing, then compiles the program; later starts compile what changed."
./install_packages.sh run
if [ ! -e build/build.ninja ]; then
  echo "Configuring ..."
  cmake --preset release -DGELENK_TESTS=OFF -DGELENK_BENCHMARKS=OFF >/dev/null
fi
# [files done/all, share, seconds]
NINJA_STATUS='[%f/%t %p %es] ' cmake --build build --target gelenk

if [ $# -eq 0 ] && [ -z "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
  echo "There is no display: a scripted drag of the figure's hands is rendered without a window."
  mkdir -p out
  build/gelenk sandbox figure --offscreen --replay assets/scenes/raise_hands.replay --screenshot out/raise_hands.png --status out/raise_hands.json
  echo "Picture and state after the last frame: $PWD/out/raise_hands.png, $PWD/out/raise_hands.json"
  exit 0
fi
exec build/gelenk "${@:-sandbox}"
