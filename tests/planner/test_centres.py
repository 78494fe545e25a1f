"""What is given of centres of mass counts wherever masses do: worlds, building, putting down, holding."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from topple.planner.building.standing import falling_in
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.suction import cup_shape
from topple.planner.placement.resting import resting_poses
from topple.planner.simulate.lifts import Stage
from topple.planner.simulate.rebuild import rebuild
from topple.planner.simulate.sandbox import Sandbox
from topple.planner.transfer.checks import Checks
from topple.robots import scene_from_world, shapes
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot
from topple.robots.world.bodies import Body
from topple.robots.world.world import World
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.statics.rest import Statics

UP = np.array([0.0, 0.0, 1.0])
OUT, IN = (0.07, 0.0, 0.205), (0.03, 0.0, 0.205)
"""Centres of a plank 1 cm beyond the edge of the block that it lies on, and 3 cm before it."""


@pytest.fixture
def world() -> Iterator[World]:
    with World() as made:
        yield made


def overhanging(world: World, centre: tuple[float, float, float]) -> Scene:
    """A plank that reaches 17 cm beyond a block, its middle 2 cm, its centre of mass where it is said."""
    world.add_table("table", size=(1.0, 1.0))
    plank = shapes.box("plank", (0.3, 0.08, 0.01))
    lower = plank.lower[2]
    middle = np.array([0.08, 0.0, 0.2 - lower])
    weighted = replace(plank, centre_of_mass=np.array(centre) - middle)
    pose = np.eye(4)
    pose[:3, 3] = middle
    world.add(shapes.box("block", (0.12, 0.12, 0.2)))
    world.add(weighted, pose)
    return scene_from_world(world.client, names={number: name for name, number in world.ids.items()})


def test_a_rebuilt_world_has_the_weight_where_it_is(world):
    scene = overhanging(world, IN)
    for centre, stays in ((IN, True), (OUT, False)):
        rebuilt = rebuild(Statics.of(scene.weighed(centres={"plank": centre})))
        turn = Statics.of(scene).upright.rotation
        pose = rebuilt.poses["plank"]
        there = pose[:3, :3] @ rebuilt.bodies["plank"].centre_of_mass + pose[:3, 3]
        assert np.allclose(there @ turn, centre, atol=1e-4)
        stage = Stage(rebuilt, 0.5, 0.5)
        assert (stage.sagged["plank"].distance < 0.01) == stays, "as PyBullet has it"
        stage.close()


def test_a_plank_is_built_where_its_centre_lets_it_stand():
    sizes = {"block": (0.12, 0.12, 0.2), "plank": (0.3, 0.08, 0.02), "weight": (0.05, 0.05, 0.05)}
    places = {"block": (0, 0, 0.1), "plank": (0.08, 0, 0.21), "weight": (-0.03, 0, 0.245)}
    clouds = {"table": np.stack(np.meshgrid(*(np.linspace(-0.3, 0.3, 120),) * 2, 0.0), -1).reshape(-1, 3)}
    for name, size in sizes.items():
        points = shapes.box(name, size).surface(6000, np.random.default_rng(0))
        clouds[name] = points - (points.max(axis=0) + points.min(axis=0)) / 2 + places[name]
    placed = frozenset({"block", "plank"})
    for centre, stands in ((IN, True), (OUT, False)):
        scene = Scene(clouds, ["table"], UP, masses={"weight": 2.0}, centres={"plank": centre})
        assert ("plank" not in falling_in(Statics.of(scene))(placed, frozenset())) == stands


def test_a_box_with_a_heavy_side_falls_over_when_it_is_put_down():
    tall = shapes.box("tall", (0.04, 0.04, 0.16))
    cloud = tall.surface(3000, np.random.default_rng(0)) + 0.08 * UP
    parts = [part + (cloud[:, 2].min() - part[:, 2].min()) * UP for part in tall.parts]
    ground = np.array([[x, y, z] for x in (-0.4, 0.4) for y in (-0.4, 0.4) for z in (0.0, -0.05)])
    low = float(cloud[:, 2].min())
    aside = {"tall": (0.03, 0.0, low + 0.08)}
    table = ground + (low - 0.002) * UP
    release = np.eye(4)
    for centres, stays in (({}, True), (aside, False)):
        scene = Scene({"tall": cloud, "table": table}, ["table"], UP, centres=centres)
        drops = Sandbox().fill("tall", {"tall": parts, "table": [table]}, UP, scene=scene)
        assert (drops.release(release)[2, 2] > 0.9) == stays
        steady = resting_poses(cloud, parts, UP, centre=scene.centres.get("tall"))
        assert any(rest.turn < 0.1 and not rest.rolls for rest in steady) == stays


def test_a_cup_holds_a_box_over_its_weight(world):
    world.add_table("table", size=(1.0, 1.0))
    pose = np.eye(4)
    world.add(shapes.box("crate", (0.16, 0.1, 0.06)), pose)
    scene = scene_from_world(world.client, names={number: name for name, number in world.ids.items()})
    tools = [cup_shape(robot("panda-suction"))]
    middle = scene.clouds["crate"].mean(axis=0)
    aside = middle + np.array([0.06, 0.0, 0.0])
    best = [
        grasp_candidates("crate", Situation.of(scene.weighed(centres={"crate": at})), tools=tools)[0]
        for at in (middle, aside)
    ]
    places = [float(grasp.pose_tool_to_world[0, 3]) for grasp in best]
    assert places[1] > places[0] + 0.03


def test_what_is_carried_weighs_where_its_centre_is():
    crate: Body = shapes.box("crate", (0.16, 0.1, 0.06))
    cloud = crate.surface(2000, np.random.default_rng(0))
    scene = Scene({"crate": cloud}, up=UP, masses={"crate": 1.5}, centres={"crate": (0.05, 0.0, 0.01)})
    arm = robot("panda")
    mass, centre = Checks("crate", Situation(scene), Station(arm, np.eye(4), np.asarray(arm.home))).load
    assert mass == 1.5
    assert np.allclose(centre, (0.05, 0.0, 0.01))
