#!/usr/bin/env bash
# The package as a user gets it: `pip install .` and `pip wheel .` of a copy of the tree's tracked files, the wheel in a fresh
# environment, used from another folder. Nothing is downloaded.
#   tests/python/install.sh PYTHON FOLDER     FOLDER is emptied
set -euo pipefail
python=$1 folder=$2
cd "$(dirname "$0")/../.."
rm -rf "$folder"
mkdir -p "$folder/tree/build"
git -c safe.directory="$PWD" ls-files -z | xargs -0 cp --parents -t "$folder/tree"
# As deep as in a checkout's own build folder, so that the compiler cache knows the files; pip needs none of this.
plain=$("$python" -c 'import skbuild.constants as c; print(c.CMAKE_BUILD_DIR())')
mkdir -p "$folder/tree/$(dirname "$plain")"
ln -s ../../build "$folder/tree/$plain"

for environment in first fresh; do "$python" -m venv --system-site-packages "$folder/$environment"; done
cd "$folder/tree"
"$folder/first/bin/pip" install --no-index .
"$folder/first/bin/pip" wheel --no-index --no-deps --wheel-dir "$folder" .
"$folder/fresh/bin/pip" install --no-index "$folder"/gelenk-*.whl
cd "$folder"
unset PYTHONPATH GELENK_PROGRAM
for environment in first fresh; do
  "$folder/$environment/bin/python" - "$folder/$environment" <<'END'
import sys

import gelenk
import numpy as np

assert gelenk.__file__.startswith(sys.argv[1]), gelenk.__file__
assert gelenk.program().startswith(sys.argv[1]), gelenk.program()
panda = gelenk.model("panda")
target = panda.fk(panda.random(1))[-1]
assert gelenk.solve(panda, target).solved
assert gelenk.render(panda, size=(160, 100)).std() > 5
assert np.isfinite(gelenk.model("figure").skin.vertices).all()
END
done
echo "installed and used: $(ls "$folder"/gelenk-*.whl)"
