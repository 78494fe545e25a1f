"""Pictures of the pages of a scene, a plan and a run, as Chromium draws them (extra `docs`, and Chromium).

python docs/figures/pages.py

With `--time` no pictures: the median of seven times in which the page of 17 objects is drawn and answers.
"""

import io
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from PIL import Image
from playwright.sync_api import sync_playwright

HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parents[1] / "examples"
SCRUB = "() => { const { player } = window.panels[0]; if (player) player.seek(0.62 * player.motion.last); }"
TOPPLE = Path(sys.executable).with_name("topple")
FRAME = """
import numpy as np
from topple.robots import scenario
with scenario("dishes", 0) as stage:
    seen = stage.cameras[0].look(stage.world, np.random.default_rng(0))
names = dict(ids=np.array(list(seen.names)), names=np.array(list(seen.names.values())))
np.savez_compressed("frame.npz", depth=seen.depth, K=seen.K, label=seen.label, rgb=seen.rgb, **names)
"""


SEVENTEEN = """
import numpy as np
from topple.planner import show_page
from topple.topology import Scene, relate
rng = np.random.default_rng(0)
boxes = {f"box {n}": rng.uniform(0, 0.08, (9000, 3)) + [n % 5 * 0.1, n // 5 * 0.1, 0] for n in range(17)}
scene = Scene(boxes, up=[0, 0, 1])
open("seventeen.html", "w").write(show_page(scene, relate(scene)))
"""
FIRST = "() => performance.getEntriesByType('navigation')[0].domContentLoadedEventEnd / 1e3"
FINEST = """() => new Promise((done) => {
  const look = () => window.panels?.every((each) => !each || !each.viewer.busy)
    ? requestAnimationFrame(() => done(performance.now() / 1e3)) : requestAnimationFrame(look);
  look();
})"""


def times() -> None:
    """Print how long after its request the page of 17 objects answers and has its finest picture."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        subprocess.run([sys.executable, "-c", SEVENTEEN], cwd=folder, check=True)
        file = Path(folder, "seventeen.html")
        for name, flags in (
            ("with WebGL by software", ["--use-angle=swiftshader"]),
            ("without WebGL", ["--disable-gpu", "--disable-software-rasterizer"]),
        ):
            browser = playwright.chromium.launch(
                executable_path=shutil.which("chromium"), args=["--no-sandbox", *flags]
            )
            page, taken = browser.new_page(viewport={"width": 1300, "height": 1000}), []
            for _ in range(7):
                page.goto(file.as_uri())
                taken.append((page.evaluate(FIRST), page.evaluate(FINEST)))
            first, finest = (median(each) for each in zip(*taken, strict=True))
            size = file.stat().st_size // 1000
            print(f"17 objects, {size} kB, {name}: answers after {first:.2f} s, finest at {finest:.2f} s")
            browser.close()


def main() -> None:
    """Make both pages, open them, and keep what one sees first."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        for command in (
            [sys.executable, "-c", FRAME],
            [TOPPLE, "show", "frame.npz", "--target", "plate", "-o", "show.html"],
            [TOPPLE, "show", "frame.npz", "--target", "plate", "-o", HERE / "order.gif"],
            [sys.executable, EXAMPLES / "01_look.py", "scene.npz"],
            [
                TOPPLE,
                "plan",
                "scene.npz",
                "--target",
                "can",
                "--robot",
                "panda-suction",
                "--report",
                "plan.html",
            ],
            [TOPPLE, "demo", "dishes", "--seed", "0"],
        ):
            subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--use-angle=swiftshader"]
        )
        page = browser.new_page(viewport={"width": 1300, "height": 1000}, device_scale_factor=1)
        high = {"page_run": 1660}  # the photo first, and the view below it
        report = next(Path(folder, "topple-demo").rglob("*.html"))
        pages = {
            "page_show": Path(folder, "show.html"),
            "page_plan": Path(folder, "plan.html"),
            "page_run": report,
        }
        for name, file in pages.items():
            page.set_viewport_size({"width": 1300, "height": high.get(name, 1000)})
            page.goto(file.as_uri())
            page.evaluate(SCRUB)
            page.wait_for_timeout(800)
            place = HERE / f"{name}.webp"
            Image.open(io.BytesIO(page.screenshot())).convert("RGB").save(place, quality=82, method=6)
            print(f"{place.name}: {place.stat().st_size // 1000} kB")
        browser.close()


if __name__ == "__main__":
    times() if sys.argv[1:] == ["--time"] else main()
