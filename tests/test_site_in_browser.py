"""The site's pages in Chromium: readable at both widths, in the light and in the dark."""

import functools
import http.server
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("mkdocs", reason="mkdocs is not installed: pip install '.[docs]'")
api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: pip install playwright")
axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here: apt-get install chromium"),
]
ROOT = Path(__file__).resolve().parents[1]
NAMES = "install commands relations results reports transcripts/ur5e transcripts/ros sam risk trust"
NAMES += " json-examples plan-fields commands/order first-frame"
PAGES = ("", *(f"{name}/" for name in NAMES.split()))
SMALLEST = """() => Math.min(...[...document.querySelectorAll("article *")].filter((e) => e.checkVisibility())
  .filter((e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()))
  .map((e) => parseFloat(getComputedStyle(e).fontSize)))"""


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: object) -> None:
        pass


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Where the built site is served."""
    folder = tmp_path_factory.mktemp("site")
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    subprocess.run(build, cwd=ROOT, env=environment, check=True, timeout=120)
    with http.server.ThreadingHTTPServer(
        ("127.0.0.1", 0), functools.partial(Quiet, directory=str(folder))
    ) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


@pytest.mark.parametrize("colours", ["light", "dark"])
def test_pages_of_the_site_are_readable(address, colours):
    wrong: list[object] = []
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        for width in (1300, 400):
            page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=colours)
            page.on("pageerror", lambda error: wrong.append(str(error)))
            page.on("console", lambda said: wrong.append(said.text) if said.type == "error" else None)
            for name in PAGES:
                page.goto(f"{address}/{name}")
                page.wait_for_timeout(300)
                if page.evaluate("document.documentElement.scrollWidth") > width:
                    wrong.append((name, width, "scrolls"))
                if page.evaluate(SMALLEST) < 12:
                    wrong.append((name, width, "small text"))
                for rule in axe.Axe().run(page).response["violations"]:
                    if rule["impact"] in ("serious", "critical"):
                        wrong.append((name, width, rule["id"], rule["nodes"][0]["html"][:100]))
        browser.close()
    assert wrong == []
