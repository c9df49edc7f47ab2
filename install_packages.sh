#!/usr/bin/env bash
# Installs the Debian packages that Gelenk is built and tested with, those that are missing only.
#   ./install_packages.sh run     to build and run the program
#   ./install_packages.sh test    that and what the tests need
#   ./install_packages.sh web     what the page of a browser is built with
#   ./install_packages.sh webtest that and the browser that tests it
set -euo pipefail
packages=(g++ cmake ninja-build ccache pkg-config libeigen3-dev libceres-dev libcli11-dev libfmt-dev nlohmann-json3-dev
          libepoxy-dev libglm-dev libglfw3-dev libimgui-dev libfreetype-dev libstb-dev libpng-dev libtinygltf-dev libassimp-dev
          liburdfdom-dev fonts-roboto-unhinted libgl1-mesa-dri libegl1 libgl1 ffmpeg gnuplot-nox)
if [ "${1:-run}" = test ]; then
  packages+=(clang-format clang-14 libclang-rt-14-dev llvm-14 libgtest-dev libgmock-dev libbenchmark-dev
             liborocos-kdl-dev xvfb xauth xdotool x11-utils
             python3-dev pybind11-dev python3-pybind11 python3-numpy python3-skbuild python3-setuptools python3-wheel
             python3-pip python3-venv python3-pytest)
fi
if [[ "${1:-run}" = web* ]]; then
  packages+=(emscripten dpkg-dev patch fonttools)
fi
if [ "${1:-run}" = webtest ]; then
  packages+=(chromium googletest)
fi
missing=()
for package in "${packages[@]}"; do
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

become_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "These packages are missing; install them as root: ${missing[*]}" >&2; exit 1; }
  become_root=(sudo)
fi
echo "Installing ${#missing[@]} packages: ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
"${become_root[@]}" apt-get update -qq
"${become_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
