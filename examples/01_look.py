"""What three depth cameras see of the built-in dishes scene, as a scene file.

    python examples/01_look.py scene.npz

One cloud (N, 3) in [m] per object under the object's name; beside them what topple cannot see: which way is
up, what never moves, where the cameras were and where the robot stands. A camera driver and a segmentation of
your own would write the same.
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image

from topple.robots import scenario
from topple.topology import Scene, thinned

SPACING = 0.002  # [m] between the points that are kept of an object: what three cameras at a metre see apart
TABLE_SPACING = 0.008  # [m] the same for the table, which is flat and large


def main(path: str, seed: int = 0) -> None:
    """Look once with the noise of a Kinect, thin the clouds and write the file."""
    rng = np.random.default_rng(seed)
    with scenario("dishes", seed) as stage:
        images = [camera.look(stage.world, rng) for camera in stage.cameras]
        scene = Scene.from_images(images, fixed=stage.fixed, up=stage.up)
        base = stage.pose_base_to_world
    clouds = {
        name: thinned(points, TABLE_SPACING if name in scene.fixed else SPACING).astype(np.float32)
        for name, points in scene.clouds.items()
    }
    about = {"up": scene.up, "fixed": sorted(scene.fixed), "viewpoints": scene.viewpoints, "robot_base": base}
    np.savez_compressed(path, **clouds, **about)
    Image.fromarray(images[0].rgb).save(Path(path).with_suffix(".png"))  # what the first one saw
    print(f"{path}: {', '.join(f'{len(points)} points of {name}' for name, points in clouds.items())}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "scene.npz")
