#!/usr/bin/env bash
# A picture of every trial body, fitted and posed, docs/pictures/rigged-bodies.png, and one of the tab Rig.
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

# The tab Rig, rig-panel.png beside it: a knee was moved, its partner went along. The frames between are for the work in the background.
gelenk=$(realpath "$gelenk") panel=$(realpath "$(dirname "$sheet")")/rig-panel.png
cp "$data/mh_male.obj" "$out"
cd "$out"
printf '%s\n' '0 do Rig human' '200 tab Rig' '201 do Rig tool on' '201 do Rig confidence on' '202 do Rig move knee_r -0.19 0.52 0.03' \
  '360 select knee_r' '360 move 437 368' > r.replay
HOME=$out XDG_CONFIG_HOME=$out LIBGL_ALWAYS_SOFTWARE=1 EGL_PLATFORM=surfaceless "$gelenk" sandbox mh_male.obj --offscreen --refine --size 1280x800 \
  --frames 380 --replay r.replay --screenshot "$panel"
