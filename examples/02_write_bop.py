"""What the cameras of the built-in dishes scene see, as a scene of a BOP dataset with its models.

python examples/02_write_bop.py bop && topple order bop/test/000001 --image 0  # the table is background there
"""

import json
import sys
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

from topple.robots import Camera, scenario
from topple.robots.world.physical_world import PhysicalWorld

SCALE = 0.1  # [mm] of one step of the depth


def write_bop(folder: Path, world: PhysicalWorld, cameras: list[Camera], seed: int = 0) -> Path:
    """Write one image a camera and one model a movable body; returns the folder of the scene."""
    scene, names = folder / "test" / "000001", list(world.movable)
    for kind in ("depth", "rgb", "mask_visib", "../../models"):
        (scene / kind).mkdir(parents=True, exist_ok=True)
    for number, name in enumerate(names, start=1):
        mesh = world.body(name).mesh
        made = trimesh.Trimesh(1e3 * mesh.vertices, mesh.faces, process=False)
        made.export(folder / "models" / f"obj_{number:06d}.ply")
    rng, eyes, truth = np.random.default_rng(seed), {}, {}
    for image, camera in enumerate(cameras):
        seen = camera.look(world, rng)
        to_camera = np.linalg.inv(camera.pose_camera_to_world)
        eyes[image] = {"cam_K": camera.K.ravel().tolist(), "depth_scale": SCALE, **_pose(to_camera, "w2c")}
        poses = [_pose(to_camera @ world.pose(name), "m2c") for name in names]
        truth[image] = [{"obj_id": number, **pose} for number, pose in enumerate(poses, start=1)]
        depth = np.round(1e3 * seen.depth / SCALE).astype(np.uint16)
        Image.fromarray(depth).save(scene / "depth" / f"{image:06d}.png")
        Image.fromarray(seen.rgb).save(scene / "rgb" / f"{image:06d}.png")
        labels = {name: label for label, name in seen.names.items()}
        for row, name in enumerate(names):
            mask = seen.label == labels.get(name, -1)
            file = scene / "mask_visib" / f"{image:06d}_{row:06d}.png"
            Image.fromarray((255 * mask).astype(np.uint8)).save(file)
    (scene / "scene_camera.json").write_text(json.dumps(eyes))
    (scene / "scene_gt.json").write_text(json.dumps(truth))
    return scene


def _pose(pose: np.ndarray, frames: str) -> dict[str, list[float]]:
    return {f"cam_R_{frames}": pose[:3, :3].ravel().tolist(), f"cam_t_{frames}": (1e3 * pose[:3, 3]).tolist()}


if __name__ == "__main__":
    with scenario("dishes") as stage:
        place = Path(sys.argv[1] if len(sys.argv) > 1 else "bop")
        print(write_bop(place, stage.world, list(stage.cameras)), end=": ")
        print(*(f"obj_{k:06d} {name}" for k, name in enumerate(stage.world.movable, 1)), sep=", ")
