"""What has to hold before anything is planned: the arm stands free."""

import numpy as np

from topple.planner.motion.collision import Checker
from topple.robots.arm.arm import Arm
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import decimal
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
            f"the start is in collision: {worst.a} of {arm.name} is {decimal(deep)} mm deep in {worst.b}: "
            "move the arm (q_start) or its base (--base X Y Z YAW)"
        )
