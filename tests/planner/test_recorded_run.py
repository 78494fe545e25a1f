"""A run sampled at every step: nothing jumps, nothing is glued, and the arm can touch everything."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pybullet
import pytest

from topple.planner.execution.loop import ClosedLoop
from topple.planner.formats.run_record import RunRecord
from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import around, pose_at
from topple.robots.world.recording import Recording
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World

FASTEST = 2.0  # [m/s] a fall of 20 cm; the tool moves at less than 1 m/s
GEAR, FIXED = "gear", "fixed"


@dataclass
class Played:
    """What was played, the world as it was left, and every step of it."""

    record: RunRecord
    recording: Recording
    arm: SimulatedArm
    world: World


@pytest.fixture(scope="module")
def played() -> Iterator[Played]:
    """A block on a plate: the block goes first, and the plate is lifted by its vacuum cup."""
    with World() as world:
        world.add_table(size=(1.4, 1.2), centre=(-0.05, 0.0))
        world.add(shapes.plate("plate"), pose_at(0.0, 0.0, 0.0))
        world.add(shapes.block("block", 0.045), pose_at(0.0, 0.0, 0.012))
        world.settle()
        arm = SimulatedArm(world, robot("panda-suction"), pose_at(-0.55, 0.0, 0.0))
        recording = Recording(arm, rate=1.0 / world.time_step)
        loop = ClosedLoop.simulated(world, arm, around((0.0, 0.0, 0.03)), "free plate")
        record = loop.run()
        recording.stop()
        yield Played(record, recording, arm, world)


def test_the_run_succeeds_and_says_what_it_did(played):
    assert played.record.success, played.record.violations
    taken = [(step.object, step.action) for step in played.record.steps]
    assert taken == [("block", "remove"), ("plate", "free")]
    for step in played.record.steps:
        assert step.slip is not None and step.slip[0] < 0.01
        assert step.to_json()["slip"] == list(step.slip)
    told = played.record.to_json()
    assert (told["format"], told["format_version"], told["success"]) == ("topple.run", 1, True)
    keys = {"object", "action", "success", "attempts", "disturbed", "relations_as_predicted", "seconds"}
    assert len(told["steps"]) == 2
    assert all(keys <= set(step) for step in told["steps"])


def test_nothing_jumps(played):
    times, poses = np.array(played.recording.times), played.recording.poses
    assert set(played.world.movable) == {"plate", "block"}
    for name in played.world.movable:
        place = np.array([pose[name][:3, 3] for pose in poses])
        speed = np.linalg.norm(np.diff(place, axis=0), axis=1) / np.diff(times)
        assert speed.max() < FASTEST, name
        assert np.linalg.norm(place[-1] - place[0]) > 0.05, f"{name} was moved"


def test_nothing_is_glued(played):
    cup = played.arm.cup
    assert cup is not None
    tied = {constraint for sample in played.recording.constraints for constraint in sample}
    for constraint in tied:
        if constraint.kind == GEAR:  # couples the two fingers
            assert (constraint.parent, constraint.child) == ("robot", "robot")
        else:
            assert (constraint.kind, constraint.parent) == (FIXED, "robot")
            assert constraint.max_force <= cup.max_force
    assert any(constraint.child == "plate" for constraint in tied), "the vacuum took the plate"
    at_the_end = played.recording.constraints[-1]
    assert all(constraint.kind == GEAR for constraint in at_the_end)


def test_every_link_still_collides_with_everything(played):
    """PyBullet tells no collision filter, so each object is put into each link that has a shape."""
    world, arm = played.world, played.arm
    links = [link for link, parts in zip(arm.arm.links, arm.arm.parts, strict=True) if parts]
    assert {"panda_hand", "panda_leftfinger", "suction_cup"} <= set(links[1:])
    assert len(world.movable) == 2
    for name in world.movable:
        for link in links[1:]:  # the base stands on the table and is fixed to it
            world.place(name, arm.link_pose(link))
            pybullet.performCollisionDetection(physicsClientId=world.client)
            points = pybullet.getContactPoints(arm.id, world.ids[name], physicsClientId=world.client)
            assert points, f"{link} does not collide with {name}"
        world.place(name, pose_at(0.3, 0.3, 0.0))
