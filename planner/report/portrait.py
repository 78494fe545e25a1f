"""A picture of an arm at home, with the block of its trial before it."""

import numpy as np

from topple.planner.execution.trial import Trial
from topple.planner.formats.pictures import picture
from topple.robots.arm.arm import Arm
from topple.robots.poses import pose_from
from topple.topology.geometry.rigid import transformed


def portrait(arm: Arm, trial: Trial | None) -> bytes:
    """Draw an arm.

    Args:
        arm: The arm, at home.
        trial: The block before it; None: the arm alone.

    Returns:
        The picture, as a PNG file has it.

    Raises:
        NotInstalled: PyBullet, which draws it, is not installed.
    """
    from topple.robots.shapes import box
    from topple.robots.world.camera import Camera
    from topple.robots.world.simulated_arm import SimulatedArm
    from topple.robots.world.world import World

    with World() as world:
        if trial is not None:
            x, y, z = trial.place
            world.add_table(height=z, size=(0.5, 0.5), centre=(x, y))
            world.add(
                box(trial.name, (trial.side, trial.side, trial.side)), pose_from((x, y, z), (0, 0, 0, 1))
            )
        SimulatedArm(world, arm, np.eye(4))
        points = np.concatenate(
            [
                transformed(part, pose)
                for parts, pose in zip(arm.parts, arm.forward(arm.home)[0], strict=True)
                for part in parts
            ]
        )
        low, high = points.min(axis=0), points.max(axis=0)
        middle, size = (low + high) / 2.0, float(np.linalg.norm(high - low))
        eye = middle + np.array([0.6, -1.0, 0.5]) * size
        x, y, z = (float(value) for value in middle)
        camera = Camera.looking_at((float(eye[0]), float(eye[1]), float(eye[2])), (x, y, z))
        return picture(camera.picture(world))
