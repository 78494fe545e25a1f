"""Whether any order of ideal lifts frees a target."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.possible import freeing_order
from topple.robots.poses import pose_from
from topple.robots.shapes import box
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray


def _at(x: float, z: float, lean: float = 0.0) -> FloatArray:
    """(4, 4) pose of something at (x, 0, z) [m] that leans about y [rad]."""
    return pose_from([x, 0.0, z], Rotation.from_euler("y", lean).as_quat())


def test_what_lies_on_the_target_goes_first():
    with World() as world:
        world.add_table()
        world.add(box("low", (0.08, 0.08, 0.04)), _at(0.0, 0.0))
        world.add(box("high", (0.06, 0.06, 0.04)), _at(0.0, 0.04))
        world.add(box("aside", (0.06, 0.06, 0.04)), _at(0.3, 0.0))
        assert world.settle()
        before = world.poses()
        assert freeing_order(world, "low") == ("high", "low")
        assert all(np.allclose(world.pose(name), pose, atol=1e-4) for name, pose in before.items())


def test_cards_that_hold_each_other_up_cannot_be_had_one_by_one():
    with World() as world:
        world.add_table()
        lean = np.radians(20.0)
        reach = 0.12 * np.sin(lean)
        world.add(box("left", (0.01, 0.1, 0.12)), _at(-reach - 0.004, 0.004, lean))
        world.add(box("right", (0.01, 0.1, 0.12)), _at(reach + 0.004, 0.004, -lean))
        world.settle()
        stands = all(world.parts(name)[0][:, 2].max() > 0.1 for name in ("left", "right"))
        assert stands
        assert freeing_order(world, "left") is None
