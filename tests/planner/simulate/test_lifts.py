import numpy as np
from moving import at

from topple.planner.simulate.lifts import take_away
from topple.robots import shapes
from topple.robots.world.world import World


def _at(x: float, z: float) -> np.ndarray:
    return at(x, 0.0, z)


def test_taking_the_lower_box_moves_the_upper_one_and_nobody_else():
    with World() as world:
        world.add_table()
        world.add(shapes.box("low", (0.1, 0.1, 0.05)), _at(0, 0))
        world.add(shapes.box("top", (0.06, 0.06, 0.05)), _at(0, 0.05))
        world.add(shapes.box("aside", (0.06, 0.06, 0.05)), _at(0.2, 0))
        world.settle(1.0)
        before = world.poses()
        without_low, without_top = take_away(world, "low"), take_away(world, "top")
        assert without_low["top"].beyond(0.01, 10)
        assert not without_low["aside"].beyond(0.001, 1)
        assert not any(move.beyond(0.002, 2) for move in without_top.values())
        assert all(np.allclose(world.pose(name), pose) for name, pose in before.items())
