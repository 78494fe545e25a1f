"""A lift that moves something else is stopped and put back, and one that moves nothing is not."""

import numpy as np
import pytest

from topple.planner.execution.execute import Outcome, execute
from topple.planner.execution.lift_monitor import ChangeDetector, LiftMonitor, neighbours_to_watch, shadow
from topple.planner.execution.look import Observer
from topple.planner.grasp.grasp import Grasp
from topple.planner.planning.order import order
from topple.planner.transfer.transfer import Transfer, TransferRequest, plan_transfer
from topple.robots import robot as robot_named
from topple.robots import shapes
from topple.robots.arm.arm import Station
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.camera import Camera
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World

EYE = Camera.looking_at((0.6, 0.25, 0.5), (0.0, 0.0, 0.05))


@pytest.fixture
def bridged() -> World:
    """A plank over two cartons, and a block that stands beside them."""
    world = World()
    world.add_table()
    for name, x in (("near", 0.0), ("far", 0.2)):
        world.add(shapes.box(name, (0.05, 0.05, 0.08), mass=0.2), pose_at(x, 0.0, 0.0))
    world.add(shapes.box("plank", (0.2, 0.02, 0.01), mass=0.1), pose_at(0.112, 0.0, 0.08))
    world.add(shapes.block("aside"), pose_at(0.0, 0.2, 0.0))
    world.settle()
    return world


def lifted(world: World, name: str) -> tuple[Outcome, dict[str, float]]:
    """What became of an object taken as though there were no plank, and how far all else moved [m]."""
    arm = SimulatedArm(world, robot_named("panda"), pose_at(-0.5, 0.0, 0.0))
    observer = Observer(world, [EYE], np.random.default_rng(0), ("table",))
    look = observer.look()
    pose = np.diag([1.0, -1.0, -1.0, 1.0])  # closing along y, the plank between the fingers
    pose[:3, 3] = world.pose(name)[:3, 3] + [0.0, 0.0, 0.055 if name == "near" else 0.03]
    grasp = Grasp(name, "pinch", pose, 0.05, 0.07, 1.0)
    station = Station(arm.arm, arm.pose_base_to_world, np.asarray(arm.arm.home))
    found = plan_transfer(name, look.situation.without("plank"), station, TransferRequest(grasps=[grasp]))
    assert isinstance(found, Transfer), found
    before = world.poses()
    others = [other for other in world.movable if other != name]
    outcome = execute(found, arm, monitor=LiftMonitor(observer, look.images, look.situation, others))
    arm.wait(1.0)
    now = world.poses()
    return outcome, {other: float(np.linalg.norm((now[other] - before[other])[:3, 3])) for other in now}


def test_what_a_lift_moves_is_seen_at_once_and_the_object_is_put_back(bridged):
    outcome, moved = lifted(bridged, "near")
    assert not outcome.success and set(outcome.moved) == {"plank"}
    assert outcome.text.startswith("near was put back: lifting it moved plank by ")
    assert moved["plank"] < 0.005 and moved["near"] < 0.005 and moved["far"] < 0.001


def test_a_lift_that_moves_nothing_is_not_stopped(bridged):
    outcome, moved = lifted(bridged, "aside")
    assert outcome.success and not outcome.moved, outcome.text
    assert moved["aside"] > 0.05 and max(moved["near"], moved["plank"]) < 0.001


def test_what_is_near_and_could_go_first_is_worth_watching(bridged):
    look = Observer(bridged, [EYE], np.random.default_rng(0), ("table",)).look()
    found = order(look.situation, ["near", "far"])
    assert neighbours_to_watch(look.situation, found, "near") == {"plank"}
    assert neighbours_to_watch(look.situation, found, "plank") == set(), "what carries it cannot go first"
    assert neighbours_to_watch(look.situation, found, "aside") == set()


def test_what_moves_is_seen_in_a_picture_and_noise_is_not(bridged):
    observer = Observer(bridged, [EYE], np.random.default_rng(0), ("table",))
    look = observer.look()
    detector = ChangeDetector(look.images, observer, (), {"aside", "plank"})
    while detector.take_reference():
        bridged.step(16)
    for _ in range(40):
        bridged.step(16)
        assert detector.still(), detector.moved
    bridged.place("aside", pose_at(0.0, 0.0, 0.008) @ bridged.pose("aside"))
    bridged.time += 16 * bridged.time_step
    assert not detector.still()
    assert detector.moved.keys() == {"aside"} and 0.005 < detector.moved["aside"] < 0.02


def test_the_shadow_of_a_part_is_what_it_hides(bridged):
    image = EYE.look(bridged)
    part = np.array([[x, y, z] for x in (-0.025, 0.025) for y in (-0.025, 0.025) for z in (0.0, 0.08)])
    hidden = shadow(image, [part])
    (number,) = (number for number, name in image.names.items() if name == "near")
    assert hidden[image.label == number].all()
    assert hidden.mean() < 0.03
    assert not shadow(image, [part + np.array([0.0, 0.0, 5.0])]).any()
