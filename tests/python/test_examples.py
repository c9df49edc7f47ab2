"""The notebooks run, and the example scripts hold the same cells."""

import ast
import json
import os
import runpy
import sys

import pytest

here = os.path.dirname(os.path.abspath(__file__))
folder = os.path.join(here, "..", "..", "docs", "python")
scripts = sorted(name for name in os.listdir(folder) if name.endswith(".py") and name != "make_notebooks.py")


def shown(value):
    """As a notebook shows what the last line of a cell gives."""
    for way in ("_repr_png_", "_repr_html_"):
        if hasattr(value, way) and getattr(value, way)() is not None:
            return way
    return repr(value)


def run(cell, space, name):
    """A cell's lines; what its last expression gives is shown, as a notebook does."""
    tree = ast.parse("".join(cell), name)
    last = ast.Expression(tree.body.pop().value) if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, name, "exec"), space)
    value = eval(compile(last, name, "eval"), space) if last else None
    return None if value is None else shown(value)


pictures = {"drag.py": 1, "rig_and_play.py": 1}


@pytest.mark.parametrize("script", scripts)
def test_the_notebook_runs_from_its_first_cell_to_its_last(script, tmp_path, monkeypatch, program):
    """The scripts hold the same lines."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [script])
    monkeypatch.setenv("GELENK_PROGRAM", program.path)
    with open(os.path.join(folder, script[:-3] + ".ipynb")) as file:
        cells = [c["source"] for c in json.load(file)["cells"] if c["cell_type"] == "code"]
    space = {"__name__": "__main__"}
    outputs = [run(cell, space, f"{script[:-3]}.ipynb, code cell {i}") for i, cell in enumerate(cells)]
    assert outputs.count("_repr_png_") == pictures.get(script, 0)


@pytest.mark.parametrize("script", scripts)
def test_the_notebook_is_the_same(script):
    make = runpy.run_path(os.path.join(folder, "make_notebooks.py"))
    with open(os.path.join(folder, script)) as file:
        wanted = make["notebook"](file.read())
    with open(os.path.join(folder, script[:-3] + ".ipynb")) as file:
        found = json.load(file)
    assert [c["source"] for c in found["cells"]] == [c["source"] for c in wanted["cells"]]
