"""Objects are set down by the force at the wrist: gently, and where they should be."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pybullet
import pytest
from on_table import table

from topple.planner.execution.execute import execute
from topple.planner.execution.tolerances import TOUCHDOWN
from topple.planner.placement.placement import Placement
from topple.planner.transfer.transfer import Transfer, TransferRequest, plan_transfer
from topple.robots import shapes
from topple.robots.arm.arm import Arm, Station
from topple.robots.catalog import robot
from topple.robots.poses import angle_between
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.bodies import Body
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.scene.scene import Scene

BASE = pose_at(-0.5, 0.0, 0.0)
PLACE = Placement(pose_at(0.0, 0.25, 0.002), 1.0)  # it hangs 2 mm above the table when it is let go

# [N] more than the weight in 20 ms: of falling 2 mm from the hand; of an arm that stops within one step
KNOCK = {0.0: 10.0, 0.006: 65.0}


def _scene(body: Body) -> Scene:
    points = _from_above(body.surface(30000, np.random.default_rng(0)))
    return Scene({body.name: points, "table": table(0.6)}, fixed=["table"], up=(0, 0, 1))


def _from_above(points: np.ndarray) -> np.ndarray:
    """Points (N, 3) that nothing of the same cloud covers: what cameras see of a plate."""
    cell = np.unique(np.round(points[:, :2] / 0.002), axis=0, return_inverse=True)[1].ravel()
    top = np.full(cell.max() + 1, -np.inf)
    np.maximum.at(top, cell, points[:, 2])
    return points[points[:, 2] > top[cell] - 0.002]


THINGS: dict[str, tuple[str, Callable[[], Body]]] = {
    "box": ("panda", lambda: shapes.box("thing", (0.05, 0.05, 0.12), mass=0.2)),
    "can": ("panda", lambda: shapes.can("thing")),
    "plate": ("panda-suction", lambda: shapes.plate("thing")),
    "another arm": ("xarm6", lambda: shapes.box("thing", (0.05, 0.05, 0.12), mass=0.2)),
}


@cache
def _carried(thing: str) -> tuple[Arm, Body, Transfer]:
    arm, body = robot(THINGS[thing][0]), THINGS[thing][1]()
    found = plan_transfer(
        "thing", _scene(body), Station(arm, BASE, np.asarray(arm.home)), TransferRequest([PLACE])
    )
    assert isinstance(found, Transfer)
    return arm, body, found


@pytest.mark.parametrize(
    "thing",
    ["box", "plate", *(pytest.param(each, marks=pytest.mark.slow) for each in ("can", "another arm"))],
)
@pytest.mark.parametrize("lower", [pytest.param(0.0, marks=pytest.mark.slow), 0.006])
def test_what_is_set_down_is_not_pressed_on(thing, lower):
    """Also where the table is nearer than it looked: the plan would press by that much."""
    arm, body, found = _carried(thing)
    with World() as world:
        world.add_table(size=(1.4, 1.2))
        there = PLACE.pose_before_to_after
        if lower:  # a thin board lies where the object is to go
            world.add(shapes.box("board", (0.3, 0.3, lower)), pose_at(*there[:2, 3], 0.0), fixed=True)
        world.add(body)
        world.settle()
        start = world.pose("thing")
        driver, forces = SimulatedArm(world, arm, BASE), list[float]()

        def watch() -> None:
            points = pybullet.getContactPoints(world.ids["thing"], physicsClientId=world.client)
            if np.linalg.norm(world.pose("thing")[:2, 3] - start[:2, 3]) > 0.05:
                forces.append(sum(point[9] for point in points if point[2] != driver.id))

        driver.on_step.append(watch)
        outcome = execute(found, driver)
        assert outcome.success, outcome.text
        driver.wait(0.5)
        end, wanted = world.pose("thing"), there @ start
        weight = 9.81 * body.mass
    most = np.convolve(forces, np.full(5, 0.2), "valid").max()  # one step of a knock says little
    assert TOUCHDOWN < most < weight + KNOCK[lower]
    assert np.linalg.norm((end - wanted)[:2, 3]) < 0.003
    assert abs(end[2, 3] - wanted[2, 3] - lower) < 0.006  # it is planned to hang a little above its place
    assert np.degrees(angle_between(end, wanted)) < 5.0
