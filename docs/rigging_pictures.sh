#!/usr/bin/env bash
# A picture of every trial body, fitted and posed: docs/pictures/rigged-bodies.png.
#   docs/rigging_pictures.sh GELENK DATA/rig OUT.png
# Needs ffmpeg.
set -euo pipefail
gelenk=$1 data=$2 sheet=$3
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
n=0
for kind in human quadruped; do
  for truth in "$data"/*.truth.json; do
    name=$(basename "$truth" .truth.json)
    grep -q '"kind": *"quad"' "$truth" && is=quadruped || is=human
    [ $is = $kind ] || continue
    "$gelenk" rig "$data/$name.obj" --skeleton $kind -o "$out" > /dev/null || continue
    if [ $kind = human ]; then
      turns=(elbow_l=50 shoulder_l.y=-25 knee_l=70 hip_l.x=-65 shoulder_r.x=35 elbow_r=30 headbase.y=20)
    else
      turns=(neck.x=-20 fshoulder_l.x=-35 felbow_l.x=40 hip_l.x=25 hip_r.x=-25 tail_root.x=30)
    fi
    look=(--azimuth 35 --elevation 8 --size 230x300 --no-ground --theme light)
    "$gelenk" render "$out/$name.glb" "${look[@]}" --bones -o "$out/$(printf %03d $n).png" > /dev/null
    "$gelenk" render "$out/$name.glb" "${look[@]}" $(printf -- '--turn %s ' "${turns[@]}") -o "$out/$(printf %03d $((n + 1))).png" > /dev/null
    n=$((n + 2))
  done
done
ffmpeg -loglevel error -y -i "$out/%03d.png" -vf "tile=8x$(((n + 7) / 8)):color=white" -frames:v 1 "$sheet"
