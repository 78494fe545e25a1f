"""Pictures of the pages: a scene's and a run's, as Chromium draws them (extra `docs`, and Chromium itself).

python docs/figures/pages.py
"""

import io
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright
from studio import save

TOPPLE = Path(sys.executable).with_name("topple")
FRAME = """
import numpy as np
from topple.robots.scenarios import scenario_called
with scenario_called("dishes", 0) as stage:
    seen = stage.cameras[0].look(stage.world, np.random.default_rng(0))
names = dict(ids=np.array(list(seen.names)), names=np.array(list(seen.names.values())))
np.savez_compressed("frame.npz", depth=seen.depth, K=seen.K, label=seen.label, rgb=seen.rgb, **names)
"""


def main() -> None:
    """Make both pages, open them, and keep what one sees first."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        for command in (
            [sys.executable, "-c", FRAME],
            [TOPPLE, "show", "frame.npz", "--target", "plate", "-o", "show.html"],
            [TOPPLE, "demo", "dishes", "--seed", "0"],
        ):
            subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1300, "height": 1000}, device_scale_factor=1)
        report = next(Path(folder, "topple-demo").rglob("*.html"))
        for name, file in (("page_show", Path(folder, "show.html")), ("page_run", report)):
            page.goto(file.as_uri())
            page.wait_for_timeout(800)
            save(Image.open(io.BytesIO(page.screenshot())).convert("RGB"), name)
        browser.close()


if __name__ == "__main__":
    main()
