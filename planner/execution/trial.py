"""A block on a small table in front of an arm, where the arm can take it from above: the least of tasks."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from topple.planner.execution.tolerances import (
    TRIAL_BEARINGS,
    TRIAL_BESIDE,
    TRIAL_BLOCK,
    TRIAL_HEIGHTS,
    TRIAL_LOW,
    TRIAL_MASS,
    TRIAL_OVER,
    TRIAL_SEEDS,
    TRIAL_SHARES,
    TRIAL_SPACING,
    TRIAL_STATES,
    TRIAL_STRAIGHT,
    TRIAL_TABLE,
    TRIAL_TURNS,
)
from topple.planner.motion.collision import Checker
from topple.robots.arm.arm import Arm
from topple.robots.arm.home import level_of, reach_of, scale_of, shoulder_of
from topple.topology.scene.scene import Scene

Place = tuple[float, float, float]


@dataclass(frozen=True)
class Trial:
    """A cube on a table, in the frame of the arm's base.

    Attributes:
        side: Of the cube [m].
        place: (x, y, z) of the middle of the face it stands on [m].
        mass: Of the cube [kg].
        name: Of the cube in the scene.
    """

    side: float
    place: Place
    mass: float = TRIAL_MASS
    name: str = "block"

    def scene(self) -> Scene:
        """Cloud of the cube and of the table top, seen from everywhere."""
        x, y, z = self.place
        ticks = np.arange(-self.side / 2, self.side / 2 + 1e-9, self.side / round(self.side / TRIAL_SPACING))
        grid = np.array(list(product(ticks, ticks)))
        ends = np.full(len(grid), self.side / 2)
        faces = [np.insert(grid, axis, sign * ends, axis=1) for axis in range(3) for sign in (-1.0, 1.0)]
        middle = np.array([x, y, z + self.side / 2])
        cube = np.unique(np.concatenate(faces).round(6), axis=0) + middle
        along = np.arange(-TRIAL_TABLE / 2, TRIAL_TABLE / 2, 2 * TRIAL_SPACING)
        table = np.array([[x + a, y + b, z] for a, b in product(along, along)])
        clouds = {"table": table, self.name: cube}
        return Scene(clouds, fixed=["table"], up=(0.0, 0.0, 1.0), masses={self.name: self.mass})

    def to_json(self) -> dict[str, Any]:
        """As it stands in a `topple.robot` document."""
        return {"shape": "cube", "side": self.side, "mass": self.mass, "place": list(self.place)}


def trial(arm: Arm, tool: str) -> Trial | None:
    """Find a place for the block.

    Args:
        arm: The arm.
        tool: Its tool.

    Returns:
        The block where the hand gets to it from above, and to places beside it; None where there is no such
        place. At the height of the base's foot where the arm is as low as that.
    """
    side = min(TRIAL_BLOCK, arm.tool(tool).gripper.widest)
    for place, bearing in _places(arm, tool, side):
        if _is_reached(arm, tool, found := Trial(side, place), bearing):
            return found
    return None


def _places(arm: Arm, tool: str, side: float) -> Iterator[tuple[Place, float]]:
    """Places before the shoulder, along x first, each with the bearing [rad] that it lies in.

    Where the tool points straight down whatever the joints do, as a gantry's, they are as low as it gets with
    room to spare, and the middle of where it gets comes first.
    """
    reach, shoulder = reach_of(arm, tool), shoulder_of(arm)
    states = np.random.default_rng(0).uniform(arm.lower, arm.upper, (TRIAL_STATES, len(arm.joints)))
    tools = arm.tool_pose(states, tool)
    if (tools[:, 2, 2] < -np.cos(TRIAL_STRAIGHT)).all():
        (x, y), heights = np.median(tools[:, :2, 3], axis=0), np.quantile(tools[:, 2, 3], TRIAL_LOW)
        levels = [float(height) - side for height in heights]
        yield from (((float(x), float(y), level), 0.0) for level in levels)
    else:
        levels = [max(0.0, level_of(arm, reach) + share * reach) for share in TRIAL_HEIGHTS]
    for bearing, level, share in product(TRIAL_BEARINGS, dict.fromkeys(levels), TRIAL_SHARES):
        x, y = shoulder[:2] + share * reach * np.array([np.cos(bearing), np.sin(bearing)])
        yield (float(x), float(y), level), bearing


def _is_reached(arm: Arm, tool: str, tried: Trial, bearing: float) -> bool:
    """Whether the hand gets to the block from above, over it, and to both sides of it, free of all else."""
    corners = np.array(list(product((-0.5, 0.5), (-0.5, 0.5), (-1.0, 0.0))))
    table = corners * [TRIAL_TABLE, TRIAL_TABLE, 0.02] + np.array(tried.place)
    checker = Checker(arm, np.eye(4), {"table": [table]}, tool_state=arm.tool(tool).ready)
    if not checker.free(arm.home)[0]:
        return False
    over, beside = scale_of(arm) * TRIAL_OVER, scale_of(arm) * TRIAL_BESIDE
    for across, above in ((0.0, 0.0), (0.0, over), (beside, 0.0), (-beside, 0.0)):
        poses = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (TRIAL_TURNS, 1, 1))
        angle = 2.0 * np.pi * np.arange(TRIAL_TURNS) / TRIAL_TURNS
        poses[:, 0, 0], poses[:, 0, 1] = np.cos(angle), np.sin(angle)
        poses[:, 1, 0], poses[:, 1, 1] = np.sin(angle), -np.cos(angle)
        x, y, z = tried.place
        aside = across * np.array([-np.sin(bearing), np.cos(bearing)])
        poses[:, :3, 3] = x + aside[0], y + aside[1], z + tried.side + above
        states = np.concatenate(arm.inverse(poses, tool, seeds=TRIAL_SEEDS))
        if not len(states) or not checker.free(states).any():
            return False
    return True
