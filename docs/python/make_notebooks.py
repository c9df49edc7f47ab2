"""The scripts of this folder as notebooks: cells begin with `# %%`. Run it after a change of a script."""

import json
from pathlib import Path


def notebook(text):
    cells = []
    for part in text.split("# %%")[1:]:
        words, _, body = part.partition("\n")
        markdown = "[markdown]" in words
        lines = body.strip("\n").split("\n")
        if markdown:
            lines = [line.removeprefix("#").removeprefix(" ") for line in lines]
        source = [line + "\n" for line in lines]
        source[-1] = source[-1].rstrip("\n")
        cell = {"cell_type": "markdown" if markdown else "code", "id": f"cell{len(cells)}", "metadata": {}, "source": source}
        if not markdown:
            cell.update(execution_count=None, outputs=[])
        cells.append(cell)
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}


def written(text):
    return json.dumps(notebook(text), indent=1) + "\n"


if __name__ == "__main__":
    for script in sorted(Path(__file__).parent.glob("*.py")):
        if script.name != Path(__file__).name:
            script.with_suffix(".ipynb").write_text(written(script.read_text()))
