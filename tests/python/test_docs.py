"""The code blocks of docs/python.md run from top to bottom, and the page names every public name."""

import re
import types

import gelenk


def test_the_pages_code_runs(root, tmp_path, monkeypatch):
    text = (root / "docs/python.md").read_text()
    blocks = list(re.finditer(r"^```python\n(.*?)^```", text, re.S | re.M))
    assert blocks
    monkeypatch.chdir(root)
    space = {"__name__": "docs", "OUT": tmp_path}
    for block in blocks:
        line = text[: block.start()].count("\n") + 1
        exec(compile("\n" * line + block.group(1), "docs/python.md", "exec"), space)


def test_the_page_names_everything(root):
    text = (root / "docs/python.md").read_text()
    for name in dir(gelenk):
        thing = getattr(gelenk, name)
        if name.startswith("_") or isinstance(thing, types.ModuleType):
            continue
        assert re.search(rf"\b{name}\b", text), name
        if isinstance(thing, type) and not issubclass(thing, Exception):
            for member in vars(thing):
                if not member.startswith("_"):
                    assert re.search(rf"\b{member}\b", text), f"{name}.{member}"


def test_the_stub_names_everything(root):
    stub = (root / "apps/python/gelenk/__init__.pyi").read_text()
    for name in dir(gelenk):
        thing = getattr(gelenk, name)
        if name.startswith("_") or isinstance(thing, types.ModuleType):
            continue
        assert re.search(rf"^(def|class) {name}\b", stub, re.M), name
        if isinstance(thing, type) and not issubclass(thing, Exception):
            body = re.search(rf"^class {name}\b.*?(?=^\S|\Z)", stub, re.S | re.M).group(0)
            for member in vars(thing):
                if not member.startswith("_"):
                    assert re.search(rf"\b{member}\b", body), f"{name}.{member}"
