"""Where the program, the inputs and the trial data lie; told by the build (tests/CMakeLists.txt)."""

import json
import os
import subprocess
from pathlib import Path

import pytest

import gelenk

os.environ.pop("LD_PRELOAD", None)  # a sanitizer's runtime is this process's alone: the program brings its own

here = Path(__file__).resolve().parent


@pytest.fixture(scope="session")
def inputs():
    return here.parent / "data"


@pytest.fixture(scope="session")
def root():
    return here.parent.parent


@pytest.fixture(scope="session")
def program():
    """Runs the command line; returns (exit status, standard output)."""
    path = os.environ.get("GELENK_PROGRAM")
    if not path or not os.path.exists(path):
        pytest.skip("the program gelenk is not there: set GELENK_PROGRAM")

    def run(*words):
        done = subprocess.run([path, *map(str, words)], capture_output=True, text=True, timeout=600)
        assert done.returncode in (0, 2), done.stderr
        return done.stdout

    run.json = lambda *words: json.loads(run(*words))
    run.path = path
    return run


@pytest.fixture(scope="session")
def panda():
    return gelenk.model("panda")


@pytest.fixture(scope="session")
def figure():
    return gelenk.model("figure")
