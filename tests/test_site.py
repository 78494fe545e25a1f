"""The site builds without a warning, and every public name has its place in the API reference."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import topple
import topple.planner
import topple.robots
import topple.topology

pytest.importorskip("mkdocs", reason="mkdocs is not installed: pip install '.[docs]'")
ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The built site; a broken link, a page without a menu entry, a missing picture: all stop it."""
    folder = tmp_path_factory.mktemp("site")
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(build, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return folder


def test_every_public_name_is_in_the_reference(site):
    packages = (topple.topology, topple.robots, topple.planner)
    for package in packages:
        page = (site / "api" / package.__name__.rpartition(".")[2] / "index.html").read_text(encoding="utf-8")
        described = set(re.findall(rf'id="{re.escape(package.__name__)}\.(\w+)"', page))
        assert set(package.__all__) <= described
    assert set(topple.__all__) - {"__version__"} <= {name for package in packages for name in package.__all__}


def test_options_in_tables_read_as_they_are_typed(site):
    html = (site / "commands" / "index.html").read_text(encoding="utf-8")
    cell = re.search(r"<td><code>topple relate(.*?)</code>", html)
    assert cell is not None and "\\" not in cell[1]
    assert '<span class="whole">--jobs</span> N | <span class="whole">--cluster</span>' in cell[1]


def test_nothing_is_fetched_from_elsewhere(site):
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 30
    for page in pages:
        html = page.read_text(encoding="utf-8")
        fetched = re.findall(r'<(?:script|img|iframe)[^>]* src="(https?:[^"]+)', html)
        fetched += re.findall(r'<link[^>]* rel="(?:stylesheet|preload|icon)"[^>]* href="(https?:[^"]+)', html)
        assert fetched == [], page


def test_broken_links_stop_the_build(tmp_path):
    spoilt = "# Here\n\n[page](gone.md) ![picture](gone.png) [heading](index.md#gone)\n"
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "index.md").write_text(spoilt, encoding="utf-8")
    settings = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    validation = settings[settings.index("validation:") : settings.index("\nnav:")]
    (tmp_path / "mkdocs.yml").write_text(f"site_name: spoilt\n{validation}", encoding="utf-8")
    build = [sys.executable, "-m", "mkdocs", "build", "--strict"]
    done = subprocess.run(build, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode != 0
    assert [place in done.stderr for place in ("gone.md", "gone.png", "#gone")] == [True] * 3, done.stderr
