"""Arms among walls and screens that no mask names: round them or not at all, never through."""

import numpy as np
import pytest

from topple.planner import plan, run
from topple.planner.errors import NoSafePlan
from topple.planner.grasp.surroundings import surroundings
from topple.planner.placement.free_space import free_spaces
from topple.planner.planning.plan_format import Plan
from topple.planner.verify.replay import Replay
from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.collision.fcl_bodies import apart
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.matter import MATTER
from topple.topology.bodies.solids import move_parts
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.views.image import DepthImage

BOX = shapes.box("box", (0.05, 0.05, 0.1))
SCREEN = shapes.box("screen", (0.01, 0.7, 0.34))
BASE = pose_at(-0.5, 0.0, 0.0)
EYES = ((0.9, 0.35, 0.6), (0.8, -0.5, 0.6), (-0.9, 0.1, 0.9))


def seen(screen: FloatArray, more: tuple[Body, ...] = (), unnamed: bool = True, what: Body = SCREEN) -> Scene:
    """A box at the origin and a screen that no mask names."""
    images: list[DepthImage] = []
    with World() as world:
        world.add_table(size=(1.6, 1.6))
        world.add(BOX, pose_at(0.0, 0.0, 0.0), fixed=True)
        for body in (what, *more):
            world.add(body, screen, fixed=True)
        rng = np.random.default_rng(0)
        for eye in EYES:
            image = Camera.looking_at(eye, (0.0, 0.0, 0.1)).look(world, rng)
            number = next((n for n, name in image.names.items() if name == "screen"), -1)
            names = {n: name for n, name in image.names.items() if n != number}
            label = np.where(image.label == number, 0, image.label)
            images.append(DepthImage(image.depth, image.K, label, image.pose_camera_to_world, names))
    return Scene.from_images(images, fixed=["table"], up=(0, 0, 1), unnamed=unnamed)


def deepest(found: Plan, screen: FloatArray, what: Body = SCREEN) -> int:
    """How many states of a plan have the arm or the box in the screen as it truly is."""
    arm = robot(found.robot)
    true, count = move_parts(what.parts, screen), 0
    base = np.array(found.pose_base_to_world)
    for piece in Replay(found, arm, 0.02).pieces:
        links = np.matmul(base, arm.forward(piece.states, piece.hand))
        tools = np.matmul(base, arm.tool_pose(piece.states, piece.segment.tool))
        for k in range(len(piece.states)):
            shown = [(part, i) for i, part in enumerate(arm.parts) if part and arm.frame_of_link[i]]
            parts = [move_parts(part, links[k, i]) for part, i in shown]
            parts += [move_parts(BOX.parts, tools[k] @ pose) for pose in piece.held.values()]
            count += sum(not apart(some, true, 0.0) for some in parts)
    return count


ACROSS = pose_at(-0.14, 0.0, 0.0)


@pytest.fixture(scope="module")
def behind() -> Scene:
    return seen(ACROSS)


def test_a_screen_is_an_obstacle_and_no_object(behind):
    assert behind.movable == ("box",)
    solids = Situation(behind).solids
    assert set(behind.names) == {"table", "box"} and set(solids) == {"table", "box", MATTER}
    corners = np.vstack(solids[MATTER])
    assert np.abs(corners[:, 0] + 0.14).max() < 0.03
    assert corners[:, 2].max() == pytest.approx(0.34, abs=0.02)
    assert np.ptp(corners[:, 1]) == pytest.approx(0.7, abs=0.04)
    assert sum("reaches beyond the objects" in said for said in behind.assumptions) == 1


def test_an_arm_goes_round_a_screen_and_never_through(behind):
    try:
        found = plan(behind, ["box"], "panda", pose_base_to_world=BASE)
    except NoSafePlan as error:
        assert MATTER in str(error)
        return
    assert deepest(found, ACROSS) == 0
    checked = found.verify(behind)
    assert checked.ok, [(bad.name, bad.value, bad.witness) for bad in checked.failed]


def test_a_plan_through_a_screen_is_refuted():
    close = pose_at(-0.08, 0.0, 0.0)
    blind = seen(close, unnamed=False)
    assert MATTER not in Situation(blind).solids
    found = plan(blind, ["box"], "panda", pose_base_to_world=BASE)
    assert found.verify(blind).ok
    assert deepest(found, close) > 0
    assert "collisions (python-fcl)" in [bad.name for bad in found.verify(seen(close)).failed]


def test_nothing_is_put_into_a_screen_and_hands_keep_clear(behind):
    (top,) = free_spaces(Situation(behind), tall=0.1)
    cell = np.floor((np.array([-0.14, 0.1]) - top.origin) / top.cell).astype(int)
    assert top.distance[tuple(cell)] == 0.0
    close = seen(pose_at(-0.05, 0.0, 0.0))
    assert MATTER in surroundings("box", close, np.array([0.0, 0.0, 1.0])).names


def test_a_box_against_a_wall_is_taken():
    wall, against = shapes.box("screen", (0.01, 0.7, 0.12)), pose_at(0.031, 0.0, 0.0)
    found = plan(seen(against, what=wall), ["box"], "panda", pose_base_to_world=BASE)
    assert deepest(found, against, wall) == 0


@pytest.mark.slow
def test_a_run_sees_the_screen_as_matter_and_goes_round_it(behind):
    record = run(behind, ["box"], "panda", pose_base_to_world=BASE)
    assert record.success, record.violations
    assert record.scene is not None and set(record.scene.names) == {"table", "box"}
    assert len(record.scene.matter) > 1000
