"""The example scripts run, and the notebooks hold the same cells."""

import json
import os
import runpy
import sys

import pytest

here = os.path.dirname(os.path.abspath(__file__))
folder = os.path.join(here, "..", "..", "docs", "python")
scripts = sorted(name for name in os.listdir(folder) if name.endswith(".py") and name != "make_notebooks.py")


@pytest.mark.parametrize("script", scripts)
def test_it_runs(script, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [script])
    runpy.run_path(os.path.join(folder, script), run_name="__main__")


@pytest.mark.parametrize("script", scripts)
def test_the_notebook_is_the_same(script):
    make = runpy.run_path(os.path.join(folder, "make_notebooks.py"))
    with open(os.path.join(folder, script)) as file:
        wanted = make["notebook"](file.read())
    with open(os.path.join(folder, script[:-3] + ".ipynb")) as file:
        found = json.load(file)
    assert [c["source"] for c in found["cells"]] == [c["source"] for c in wanted["cells"]]
