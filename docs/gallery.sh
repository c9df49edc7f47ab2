#!/usr/bin/env bash
# The pictures of docs/gallery.md: NAME.webp 1280x800 light, NAME-dark.webp 2560x1600 at scale 2.
#   docs/gallery.sh GELENK KNIGHT.glb [NAME ...]
# GELENK: the program; KNIGHT.glb: the knight of KayKit's Adventurers (CC0). Needs ffmpeg with libwebp; software rendering.
set -euo pipefail
gelenk=$(realpath "$1") knight=$(realpath "$2")
shift 2
out=$(realpath "$(dirname "$0")")/pictures/gallery
mkdir -p "$out"
work=$(mktemp -d)
export HOME=$work XDG_CONFIG_HOME=$work/.config  # pictures name no folder of the machine
cp "$(dirname "$0")"/../assets/scenes/* "$work"
trap 'rm -rf "$work"' EXIT
export LIBGL_ALWAYS_SOFTWARE=1 EGL_PLATFORM=surfaceless
wanted=" $* "
cd "$work"

webp() { ffmpeg -loglevel error -y -i "$1" -quality "$3" -compression_level 6 "$2"; }

# shot NAME MODEL FRAMES, the replay on standard input: pixels stand as {N} and are those of scale 1.
shot() {
  local name=$1 model=$2 frames=$3 script scale theme
  script=$(cat)
  [ "$wanted" = "  " ] || [[ "$wanted" == *" $name "* ]] || return 0
  for scale in 1 2; do
    [ "$scale" = 1 ] && theme=light || theme=dark
    echo "$script" | awk -v s="$scale" '{ while (match($0, /\{-?[0-9]+\}/))
      $0 = substr($0, 1, RSTART - 1) substr($0, RSTART + 1, RLENGTH - 2) * s substr($0, RSTART + RLENGTH); print }' > r.replay
    "$gelenk" sandbox "$model" --offscreen --refine --theme "$theme" --scale "$scale" --size $((1280 * scale))x$((800 * scale)) \
      --frames "$frames" --replay r.replay --screenshot shot.png
    [ "$scale" = 1 ] && webp shot.png "$out/$name.webp" 88 || webp shot.png "$out/$name-dark.webp" 75
  done
}

shot robots ur5 40 <<'R'
0 drag tool {-110} {-60} 8
12 tab Model
R
shot gltf "$knight" 12 <<'R'
0 tab Motion
1 do Motion frame 12
R
shot mathematics lecture:pseudo-inverse 12 <<'R'
0 key f5
R
shot map planar 120 <<'R'
0 drag end-effector {-30} {-40} 12
20 show convergence on
20 show velocity_ellipsoid on
21 tab Pictures
R
shot muscles figure 90 <<'R'
0 tab Muscles
1 do Muscles layers on
2 do Muscles alone on
20 do Muscles bend 95
60 move {800} {10}
R
shot files figure 14 <<'R'
0 keydown ctrl
1 key o
2 keyup ctrl
R
shot hands figure 110 <<'R'
0 drag hand_r {-60} {-170} 8
R
shot solvers figure 110 <<'R'
0 drag hand_r {-80} {-60} 12
14 move {1060} {77}
15 press left
16 release left
30 move {1050} {241}
R
shot layout figure 16 <<'R'
0 keydown ctrl
1 key k
2 keyup ctrl
4 text lecture newton
R
shot look figure 110 <<'R'
0 drag hand_l {90} {-160} 8
12 show handles off
13 select head
13 move {300} {100}
14 key f
R

if [ "$wanted" = "  " ] || [[ "$wanted" == *" film "* ]]; then
  printf '0 drag hand_r -60 -150 30\n40 drag hand_l 90 -190 30\n' > r.replay
  "$gelenk" render figure --replay r.replay --size 320x300 -o film.gif
  cp film.gif "$out/film.gif"
fi
