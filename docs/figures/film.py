"""The moving picture of the README: a run of the dishes scene, filmed and sped up.

    python docs/figures/film.py [docs/dishes.webp]

Leaves with exit code 1, and writes nothing, where the run fails.
"""

import sys
from pathlib import Path

from PIL import Image

from topple.planner.execution.demo import loop_in
from topple.robots.scenarios import scenario_called
from topple.robots.world.camera import Camera

SPEED = 8  # times as fast as simulated time
RATE = 10  # pictures a second
LAST = 2500  # [ms] the last picture stands, so that one sees how it ended
EYE, TARGET = (0.62, -0.72, 0.62), (-0.14, 0.0, 0.16)  # [m] arm and table fill the picture
SIZE = (640, 480)  # [pixels]


def main(target: str = "docs/dishes.webp") -> int:
    """Play, take a picture every so often, write them as one moving picture."""
    camera = Camera.looking_at(EYE, TARGET, width=SIZE[0], height=SIZE[1])
    pictures: list[Image.Image] = []
    with scenario_called("dishes", 0) as stage:
        loop = loop_in(stage, progress=print)
        begun = stage.world.time

        def look() -> None:
            if stage.world.time >= begun + len(pictures) * SPEED / RATE:
                pictures.append(Image.fromarray(camera.picture(stage.world)))

        loop.robot.on_step.append(look)
        record = loop.run()
    if not record.success:
        print(*record.violations, sep="\n")
        return 1
    waits = [1000 // RATE] * (len(pictures) - 1) + [LAST]
    first, *others = pictures
    first.save(target, save_all=True, append_images=others, duration=waits, loop=0, quality=70, method=6)
    print(f"{target}: {len(pictures)} pictures, {Path(target).stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
