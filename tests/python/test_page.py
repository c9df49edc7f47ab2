"""The page below a notebook's cell, in a real browser: chromium, and the page that ./web.sh has built."""

import os
import shutil
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import numpy as np
import pytest

import gelenk

site = Path(os.environ.get("GELENK_PAGE") or Path(__file__).resolve().parents[2] / "build-web" / "site")


def test_without_a_page_it_says_so(tmp_path, panda):
    with pytest.raises(FileNotFoundError, match="web.sh"):
        gelenk.embed(panda, site=tmp_path)


def test_the_address_alone_is_answered(tmp_path, panda):
    (tmp_path / "gelenk.wasm").write_bytes(b"")
    (tmp_path / "index.html").write_text("the page")
    page = gelenk.embed(panda, site=tmp_path, theme="dark")
    assert page.address in page._repr_html_() and not page.closed
    assert b"theme=dark" in urllib.request.urlopen(page.address).read()
    base = page.address.rsplit("/", 2)[0]
    assert urllib.request.urlopen(base + "/index.html").read() == b"the page"
    for wrong in (base + "/frame", base + "/0/tell", base + "/../secret"):
        with pytest.raises(urllib.error.HTTPError):
            urllib.request.urlopen(wrong)
    with pytest.raises(urllib.error.HTTPError):
        urllib.request.urlopen(base + "/0/told", data=b"{}")
    with pytest.raises(RuntimeError, match="no browser"):
        page.q
    for wrong in (lambda: gelenk.embed(panda, theme="green", site=tmp_path), lambda: gelenk.embed(panda, [1, 2], site=tmp_path)):
        with pytest.raises(ValueError):
            wrong()
    page.close()
    page.close()
    assert page.closed
    with pytest.raises(RuntimeError, match="closed"):
        page.q


def until(condition, seconds=200):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.1)
    return False


@pytest.mark.skipif(not (site / "gelenk.wasm").exists() or not shutil.which("chromium"), reason="no page is built, or no chromium is here")
def test_a_hand_that_is_dragged_in_the_notebook_comes_back(figure, root):
    sys.path.insert(0, str(root / "tests" / "web"))
    from browser import Browser

    q = figure.rest
    q[figure.q_slice("lowerarm_l")][0] = 0.6
    page = gelenk.embed(figure, q, site=site)
    with Browser() as browser:
        browser.size(900, 600)
        browser.open(page.address)
        assert until(lambda: page._pose), browser.console
        assert np.array_equal(page.q, q)
        page.q = figure.rest
        assert np.array_equal(page.q, figure.rest)
        time.sleep(1)  # the camera comes to rest
        at = next(g["pixel"] for g in page.goals if g["name"] == "hand_r")
        browser.mouse("mouseMoved", *at)
        browser.mouse("mousePressed", *at)
        for k in range(1, 11):
            browser.mouse("mouseMoved", at[0] - 2 * k, at[1] - 4 * k, held=True)
        assert until(lambda: page._pose["dragging"] == "hand_r")
        assert until(lambda: next(g for g in page.goals if g["name"] == "hand_r")["error"] < 2e-3)
        browser.mouse("mouseReleased", at[0] - 20, at[1] - 40)
        assert until(lambda: not page._pose["dragging"])
        now = page._now()
        there = figure.fk(now["q"])[figure.index("hand_r")][:3, 3]
        before = figure.fk(figure.rest)[figure.index("hand_r")][:3, 3]
        held = next(g for g in now["goals"] if g["name"] == "hand_r")
        assert np.linalg.norm(there - before) > 0.02 and np.allclose(there, held["reached"], atol=1e-9)
    page.close()
