"""Carrying a transfer out: what is not where it was seen is met, not pushed."""

import numpy as np
from on_table import table

from topple.planner.execution.execute import execute
from topple.planner.grasp.grasp import Grasp
from topple.planner.placement.placement import Placement
from topple.planner.transfer.transfer import Transfer, TransferRequest, plan_transfer
from topple.robots import shapes
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.bodies import Body
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene

BASE = pose_at(-0.5, 0.0, 0.0)
PANDA = robot("panda")


def _seen(height: float) -> Scene:
    return _on_table(shapes.box("box", (0.05, 0.05, height)))


def _on_table(body: Body) -> Scene:
    """A body on a table, as whole clouds show it."""
    points = body.surface(3000, np.random.default_rng(0))
    return Scene({body.name: points, "table": table(0.6)}, fixed=["table"], up=(0, 0, 1))


def test_a_cup_that_meets_the_object_early_is_not_pressed_on():
    hand = robot("panda-suction")
    with World() as world:
        world.add_table(size=(1.4, 1.2))
        world.add(shapes.box("box", (0.05, 0.05, 0.124), mass=0.2), pose_at(0.0, 0.0, 0.0))
        world.settle()
        found = plan_transfer("box", _seen(0.12), Station(hand, BASE, np.asarray(hand.home)))
        assert isinstance(found, Transfer)
        assert found.grasp.tool == "suction"
        arm = SimulatedArm(world, hand, BASE)
        outcome = execute(found, arm)
        assert outcome.success, outcome.text


def test_fingers_that_meet_the_object_stop_and_go_back():
    with World() as world:
        world.add_table(size=(1.4, 1.2))
        world.add(shapes.box("box", (0.05, 0.05, 0.12), mass=0.2), pose_at(0.0, 0.0, 0.0))
        world.settle()
        found = plan_transfer("box", _seen(0.12), Station(PANDA, BASE, np.asarray(PANDA.home)))
        assert isinstance(found, Transfer)
        across = found.grasp.pose_tool_to_world[:3, 1]  # a finger now comes down on top of it
        pose = world.pose("box")
        pose[:3, 3] += 0.03 * across
        world.place("box", pose)
        arm = SimulatedArm(world, PANDA, BASE)
        outcome = execute(found, arm)
        moved = np.linalg.norm(world.pose("box")[:3, 3] - pose[:3, 3])
        assert not outcome.success
        assert outcome.text == "the fingers met something on their way to box."
        assert moved < 0.003
        assert arm.touched["box"].impulse < 0.3  # [N s] a knock, no push of half a second
        assert np.abs(arm.q - _start(found, 1)).max() < 0.02  # above it again


def _start(transfer: Transfer, number: int) -> FloatArray:
    """(n,) joint values with which one of its motions starts."""
    trajectory = transfer.segments[number].motion
    assert trajectory is not None
    return trajectory.positions[0]


def test_in_a_vessel_the_hand_opens_no_wider_than_letting_go_takes():
    bodies = {
        "cube": (shapes.box("cube", (0.04, 0.04, 0.06), mass=0.1), pose_at(0.0, -0.25, 0.0)),
        "tray": (shapes.box("tray", (0.3, 0.2, 0.01)), pose_at(0.0, 0.1, 0.0)),
        "left": (shapes.box("left", (0.04, 0.1, 0.06), mass=0.05), pose_at(-0.072, 0.1, 0.01)),
        "right": (shapes.box("right", (0.04, 0.1, 0.06), mass=0.05), pose_at(0.072, 0.1, 0.01)),
    }
    rng = np.random.default_rng(0)
    clouds = {n: b.surface(3000, rng) @ p[:3, :3].T + p[:3, 3] for n, (b, p) in bodies.items()}
    table = _on_table(bodies["cube"][0]).clouds["table"]
    scene = Scene({**clouds, "table": table}, fixed=["table"], up=(0, 0, 1))
    grasp = np.diag([1.0, -1.0, -1.0, 1.0])
    grasp[:3, :2] = [[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]  # closing towards the neighbours at its place
    grasp[:3, 3] = [0.0, -0.25, 0.045]
    between = Placement(pose_at(0.0, 0.35, 0.012), 1.0, drop=0.002, into="tray")
    hold = Grasp("cube", "pinch", grasp, 0.04, 0.056, 1.0, "", {})
    with World() as world:
        world.add_table(size=(1.4, 1.2))
        for body, pose in bodies.values():
            world.add(body, pose)
        world.settle()
        before = world.poses()
        found = plan_transfer(
            "cube", scene, Station(PANDA, BASE, np.asarray(PANDA.home)), TransferRequest([between], [hold])
        )
        assert isinstance(found, Transfer), found
        outcome = execute(found, SimulatedArm(world, PANDA, BASE))
        assert outcome.success, outcome.text
        moved = {name: np.linalg.norm(world.pose(name)[:3, 3] - before[name][:3, 3]) for name in bodies}
    assert moved["cube"] > 0.3
    assert max(moved["left"], moved["right"]) < 1e-3, "fingers wide open would push them aside"
