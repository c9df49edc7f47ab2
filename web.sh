#!/usr/bin/env bash
# The sandbox as a page (docs/web.md): installs what is missing, builds, and puts plain static files into build-web/site/.
#   ./web.sh                 builds
#   ./web.sh serve [PORT]    builds, then shows it on http://127.0.0.1:PORT/ (default 8321) until Ctrl+C
set -euo pipefail
cd "$(dirname "$0")"
case "${1:-}" in ""|serve) ;; *) echo "usage: ./web.sh [serve [PORT]]" >&2; exit 1;; esac
port=${2:-8321}
[[ "$port" =~ ^[0-9]+$ ]] && [ "$port" -le 65535 ] || { echo "web.sh: expected a port from 0 to 65535, found '$port'" >&2; exit 1; }
./install_packages.sh web
apps/web/fetch_sources.sh build-web/sources
export NODE_PATH=/usr/share/nodejs  # where emscripten's parser of JavaScript lies
cmake --preset web >/dev/null
cmake --build --preset web --target site
echo "The page lies in build-web/site: $(cd build-web/site && ls | tr '\n' ' ')"
[ "${1:-}" = serve ] || exit 0
exec python3 -m http.server --bind 127.0.0.1 --directory build-web/site "$port"
