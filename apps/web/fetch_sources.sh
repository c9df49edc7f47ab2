#!/usr/bin/env bash
# Sources of what the core is compiled with in WebAssembly, from the same archive as the distribution's packages:
#   apps/web/fetch_sources.sh FOLDER      puts imgui and tinyxml there
set -euo pipefail
folder=$1
mkdir -p "$folder"
cd "$folder"
[ -d tinyxml ] && [ -d imgui ] && exit 0
mkdir -p apt/lists/partial apt/archive
shopt -s nullglob
: > apt/deb-src.sources
: > apt/deb-src.list
for file in /etc/apt/sources.list.d/*.sources; do
  sed 's/^Types:.*/Types: deb-src/' "$file" >> apt/deb-src.sources
  echo >> apt/deb-src.sources
done
for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
  [ -e "$file" ] && sed -n 's/^deb /deb-src /p' "$file" >> apt/deb-src.list
done
parts=$PWD/apt/parts
mkdir -p "$parts"
mv apt/deb-src.sources apt/deb-src.list "$parts"
options=(-q -o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$parts" -o Dir::State::lists="$PWD/apt/lists"
         -o APT::Sandbox::User=root)
echo "Fetching the sources of Dear ImGui and TinyXML"
apt-get "${options[@]}" update >/dev/null
(cd apt/archive && apt-get "${options[@]}" source imgui tinyxml >/dev/null)
for name in imgui tinyxml; do
  found=(apt/archive/"$name"-*/)
  [ ${#found[@]} -eq 1 ] || { echo "No source of $name was found; the archive gave: $(ls apt/archive)" >&2; exit 1; }
  rm -rf "$name"
  mv "${found[0]}" "$name"
done
rm -rf apt
