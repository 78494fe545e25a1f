"""Small scenes the report tests draw: real clouds, related and ordered by topple itself."""

import numpy as np
import pytest
from carrying import carried

from topple.planner.formats.pictures import picture
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.planning.order import order
from topple.planner.planning.plan import plan
from topple.robots.catalog import robot
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage

NASTY = '</script><b>"it\'s" & <!--'
"""A name that would end the script, open a tag or break an attribute if it were not escaped."""


def box_cloud(centre, size, count=400, seed=0):
    """Points on the surface of an axis-aligned box [m]."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.5, 0.5, (count, 3))
    side = rng.integers(0, 3, count)
    points[np.arange(count), side] = np.sign(points[np.arange(count), side]) * 0.5
    return points * size + centre


def stack_scene(names=("crate", "tin", NASTY), up=(0, 0, 1)):
    """A table with boxes stacked on it, one beside them."""
    clouds = {"table": box_cloud((0, 0, -0.01), (0.8, 0.8, 0.02), 2000, 9)}
    for level, name in enumerate(names):
        clouds[name] = box_cloud((0, 0.01 * level, 0.05 + 0.1 * level), (0.12, 0.1, 0.1), seed=level)
    clouds["beside"] = box_cloud((0.25, 0, 0.03), (0.06, 0.06, 0.06), seed=7)
    return Scene(clouds, fixed=["table"], up=up)


@pytest.fixture(scope="session")
def half_seen():
    """A box on a table of which one camera saw the top and the side towards it."""
    box = box_cloud((0, 0, 0.05), (0.1, 0.1, 0.1), 6000)
    seen = box[(box[:, 0] < -0.049) | (box[:, 2] > 0.099)]
    table = box_cloud((0, 0, -0.01), (0.8, 0.8, 0.02), 4000, 9)
    return Scene({"table": table, "box": seen}, fixed=["table"], up=[0, 0, 1], viewpoints=[[-0.8, 0, 0.6]])


@pytest.fixture(scope="session")
def stack():
    scene = stack_scene()
    relations = relate(scene)
    return scene, relations, order(scene, ["crate"], relations=relations)


@pytest.fixture(scope="session")
def photographed():
    """A scene of one photo: two boxes side by side on a table, the labels of both bare numbers."""
    depth, label = np.full((120, 160), 0.9), np.full((120, 160), 9)
    for number, columns in ((1, slice(30, 70)), (2, slice(80, 120))):
        depth[40:80, columns], label[40:80, columns] = 0.82, number
    rgb = np.random.default_rng(0).integers(90, 160, (120, 160, 3)).astype(np.uint8)
    K = np.array([[150.0, 0, 80], [0, 150.0, 60], [0, 0, 1]])
    scene = Scene.from_images([DepthImage(depth, K, label, rgb=rgb)], fixed=["9"])
    relations = relate(scene)
    return scene, relations, order(scene, relations=relations)


@pytest.fixture(scope="session")
def panda():
    return robot("panda")


@pytest.fixture(scope="session")
def lone_plan():
    """A box in front of a Panda, and the plan to take it."""
    box = box_cloud((0.5, 0, 0.04), (0.05, 0.05, 0.08), 1500)
    top = np.random.default_rng(9).uniform((0.2, -0.4, 0), (0.9, 0.4, 0), (20_000, 3))
    scene = Scene({"table": top, "box": box}, fixed=["table"], up=[0, 0, 1], robot_base=np.eye(4))
    return plan(scene, "free box", "panda"), scene


@pytest.fixture(scope="session")
def run_record(panda):
    scene = stack_scene()
    steps = []
    for number, name in enumerate([NASTY, "tin"]):
        relations = relate(scene)
        after = scene.without(name)
        steps.append(
            StepRecord(
                object=name,
                action="take off",
                success=True,
                disturbed={"beside": (0.0012, 0.01)} if number == 0 else {"beside": (0.02, 0.3)},
                relations_as_predicted=number == 0,
                seconds=1.5,
                reason="It rests on what is wanted.",
                picture_before=picture(np.full((48, 64, 3), 40 + number, dtype=np.uint8)),
                picture_after=picture(np.full((48, 64, 3), 41 + number, dtype=np.uint8)),
                scene=scene,
                relations=relations.to_json(),
                order=order(scene, ["crate"], relations=relations).to_json(),
                predicted=relate(after).to_json() if number == 0 else relations.to_json(),
                observed=relate(after).to_json(),
                motion=carried(name, panda),
                tool_path=np.linspace([0, 0, 0.4], [0.3, 0, 0.2], 1000),
                forces={"beside": 1.25},
                severity={} if number == 0 else {"beside": (0.12, 0.3)},
            )
        )
        scene = after
    return RunRecord(
        goal="free crate",
        robot="panda",
        seed=3,
        success=False,
        violations=("beside moved 20 mm",),
        steps=tuple(steps),
        seconds=3.1,
        scene=scene,
        relations=relate(scene).to_json(),
        arm=panda,
        notes=("the base stands at 0.5 m",),
    )
