"""What has to hold before anything is planned: the arm stands free, and marks name things that are there."""

from collections.abc import Collection

import numpy as np

from topple.planner.motion.collision import Checker
from topple.robots.arm.arm import Arm
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.values import rounded
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


def check_start(situation: Situation, arm: Arm, pose_base_to_world: FloatArray, q_start: FloatArray) -> None:
    """Refuse a start from which nothing can be planned.

    Args:
        situation: What is seen.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        q_start: (n,) joint values [rad].

    Raises:
        InvalidInput: The values have the wrong shape, are beyond a limit, or the arm touches something; the
            message names the joint, or the link and what it touches.
    """
    if q_start.shape != (len(arm.joints),) or not np.isfinite(q_start).all():
        raise InvalidInput(
            f"q_start: {arm.name} has {len(arm.joints)} joints: expected as many finite values, "
            f"found an array {q_start.shape}"
        )
    for name, value, low, high in zip(arm.joints, q_start, arm.lower, arm.upper, strict=True):
        if not low - 1e-6 <= value <= high + 1e-6:
            raise InvalidInput(f"q_start: {name} is {value:.3f}: expected {low:.3f} to {high:.3f}")
    contacts = Checker(arm, pose_base_to_world, situation.solids).contacts(q_start)
    if contacts:
        worst = contacts[0]
        deep = 1e3 * max(-worst.distance, 0.0)
        raise InvalidInput(
            f"the start is in collision: {worst.a} of {arm.name} is {rounded(deep)} mm deep in {worst.b}: "
            "move the arm (q_start) or its base (--base X Y Z YAW)"
        )


def check_upright(scene: Scene, upright: Collection[str]) -> frozenset[str]:
    """Refuse marks of what is not there.

    Args:
        scene: The scene.
        upright: Names of objects to be kept upright.

    Returns:
        The names.

    Raises:
        UnknownObject: A name is not in the scene.
    """
    names = frozenset([upright] if isinstance(upright, str) else upright)
    if unknown := sorted(names - scene.clouds.keys()):
        raise UnknownObject(unknown[0], scene.names)
    return names
