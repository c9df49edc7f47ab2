#!/usr/bin/env bash
# The tables of docs/rigging.md: rigs every trial body and lets an independent judge compare it with the artist's skeleton.
#   docs/rigging_table.sh GELENK DATA/rig JUDGE.py
# GELENK: the program; DATA/rig: NAME.obj with NAME.truth.json; JUDGE.py: prints JSON with --json FILE.
set -euo pipefail
gelenk=$1 data=$2 judge=$3
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
python=${PYTHON:-python3}
score() { # file with the judge's answer
  "$python" - "$@" <<'PY'
import json, sys
name, report, answer, kind = sys.argv[1:5]
s = json.load(open(report))[0]
r = json.load(open(answer))
def cell(key, form='%.2f'):
    return form % r[key] if isinstance(r.get(key), (int, float)) else '-'
pose = ('pose_thigh', 'pose_arm', 'pose_elbow') if kind == 'human' else ('pose_hind', 'pose_fore')
print('| %s | %s / %s | %s | %s | %s | %s | %s | %s | %.2f | %.2f |' % (
    name, cell('limb_mean'), cell('limb_max'), cell('core_mean'), cell('asym_max'), cell('outside_max'), cell('l1', '%.3f'),
    ' / '.join(cell(k) for k in pose), cell('stretch_rel'), s['confidence'], s['seconds']))
PY
}
for kind in human quadruped; do
  [ $kind = human ] && poses='thigh / arm / elbow' || poses='hind / fore'
  echo "| body | limbs mean / max | core | asymmetry | outside | l1 | pose $poses | stretch | confidence | s |"
  echo '|---|---|---|---|---|---|---|---|---|---|'
  for truth in "$data"/*.truth.json; do
    name=$(basename "$truth" .truth.json)
    grep -q '"kind": *"quad"' "$truth" && is=quadruped || is=human
    [ $is = $kind ] || continue
    if ! "$gelenk" rig "$data/$name.obj" --skeleton $kind -o "$out" --json > "$out/$name.json" 2> "$out/refusal"; then
      echo "| $name | $(sed 's/.*: //' "$out/refusal") | | | | | | | | |"
      continue
    fi
    "$python" "$judge" "$data/$name.obj" "$truth" "$out/$name.skeleton.out" "$out/$name.attachment.out" --quiet --json "$out/$name.score"
    [ $kind = human ] && k=human || k=quad
    score "$name" "$out/$name.json" "$out/$name.score" $k
  done
  echo
done
