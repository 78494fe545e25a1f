"""What stands where no camera looks: the support it gets by inference, and no other."""

import numpy as np
import pytest

from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology.bodies.complete import complete, is_hollow
from topple.topology.bodies.upright import Upright
from topple.topology.relations.inferred import MEET
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.sixim.confidence import Evidence, confidence
from topple.topology.sixim.table import Relation
from topple.topology.statics.rest import Statics
from topple.topology.views.free_space import FreeSpace
from topple.topology.views.image import DepthImage

UP = (0.0, 0.0, 1.0)
EYES = ((0.15, -0.1, 0.75), (-0.15, 0.15, 0.75))  # [m] steep: undersides and feet stay hidden
VIEW = float(np.radians(35))
Spot = tuple[float, float, float]

LOW = shapes.box("low", (0.10, 0.10, 0.05))
TOP = shapes.box("top", (0.06, 0.06, 0.05))
BESIDE = shapes.box("beside", (0.06, 0.10, 0.05))
HIDDEN = shapes.box("hidden", (0.06, 0.06, 0.04))
WIDE = shapes.box("wide", (0.14, 0.14, 0.05))


def rendered(bodies: list[tuple[Body, Spot]], cameras: int) -> Scene:
    """Bodies put where they are told, as depth cameras from above see them."""
    with World() as world:
        world.add_table(size=(0.8, 0.8))
        for body, spot in bodies:
            world.add(body, pose_at(*spot), fixed=True)
        rng = np.random.default_rng(0)
        looking = [
            Camera.looking_at(e, (0, 0, 0.03), width=320, height=240, fov=VIEW) for e in EYES[:cameras]
        ]
        images = [camera.look(world, rng) for camera in looking]
    return Scene.from_images(images, fixed=["table"], up=UP)


SCENES = {
    "block on table": ([(LOW, (0.0, 0.0, 0.0))], {("table", "low")}),
    "block on block": ([(LOW, (0.0, 0.0, 0.0)), (TOP, (0.0, 0.0, 0.05))], {("table", "low"), ("low", "top")}),
    "beside another": (
        [(LOW, (0.0, 0.0, 0.0)), (BESIDE, (0.13, 0.0, 0.0))],
        {("table", "low"), ("table", "beside")},
    ),
    "on one that nobody sees": (  # of what is seen, only the table can carry it
        [(HIDDEN, (0.0, 0.0, 0.0)), (WIDE, (0.0, 0.0, 0.04))],
        {("table", "wide")},
    ),
    "block on block beside another": (
        [(LOW, (0.0, 0.0, 0.0)), (TOP, (0.0, 0.0, 0.05)), (BESIDE, (0.13, 0.0, 0.0))],
        {("table", "low"), ("low", "top"), ("table", "beside")},
    ),
}


@pytest.mark.parametrize("cameras", [1, 2])
@pytest.mark.parametrize("name", SCENES)
def test_everything_has_its_support_and_no_other(name, cameras):
    bodies, wanted = SCENES[name]
    scene = rendered(bodies, cameras)
    relations = relate(scene)
    touching = {frozenset((p.a, p.b)) for p in relations if p.relation is not Relation.DISJOINT}
    assert touching == {frozenset(pair) for pair in wanted}
    assert {(s.supporter, s.supported) for s in Situation(scene, relations).supports} == wanted
    for pair in relations:
        if "table" in (pair.a, pair.b) and pair.relation is Relation.TOUCH:
            assert pair.inferred and not pair.observed  # the sides are seen so steeply that no foot is
            evidence = Evidence.MEETS if pair.reason == MEET else Evidence.FLOATS
            assert pair.confidence == confidence(evidence, cameras)


def test_what_is_added_to_a_box_lies_within_it_and_where_nobody_saw_through():
    upright = Upright.of(rendered([(LOW, (0.0, 0.0, 0.0))], 2))
    assert upright.viewpoints is not None
    sight = FreeSpace(upright.clouds, upright.viewpoints)
    whole = complete(upright, sight)
    assert np.array_equal(whole["table"], upright.clouds["table"])
    seen = upright.clouds["low"]
    assert np.array_equal(whole["low"][: len(seen)], seen)
    level = np.abs(whole["low"] @ upright.rotation)
    inside = (level < 0.065).all(axis=1)  # noise along the line of sight takes seen points to 0.061
    assert inside[len(seen) :].all()
    assert not sight.empty(whole["low"][len(seen) :]).any()


def test_whole_clouds_are_left_as_they_are():
    rng = np.random.default_rng(0)
    ground = np.c_[rng.uniform(-0.2, 0.2, (4000, 2)), np.zeros(4000)]
    upright = Upright.of(Scene({"table": ground, "low": LOW.surface(6000, rng)}, fixed=["table"], up=UP))
    assert np.array_equal(complete(upright, None)["low"], upright.clouds["low"])


def test_hollow_things_are_told_from_full_ones():
    rng = np.random.default_rng(0)
    for body, hollow in ((shapes.bowl(), True), (shapes.mug(), True), (LOW, False), (shapes.can(), False)):
        assert is_hollow(body.surface(6000, rng), None) is hollow, body.name


def test_space_is_empty_in_front_of_what_was_seen_and_nowhere_else():
    across = np.linspace(-0.2, 0.2, 81)
    wall = np.stack(np.meshgrid(across, across, [0.0]), axis=-1).reshape(-1, 3)
    sight = FreeSpace({"seen": wall}, np.array([[0.0, 0.0, 1.0]]))
    places = np.array([[0, 0, 0.5], [0, 0, 0.05], [0, 0, 0.005], [0, 0, -0.1], [0.5, 0, 0.5]])
    assert sight.empty(places).tolist() == [True, True, False, False, False]
    assert len(sight.empty(places[:0])) == 0


def test_beyond_a_picture_s_edge_nothing_was_seen_whatever_others_saw_there():
    across = np.linspace(-0.5, 0.5, 201)
    wall = np.stack(np.meshgrid(across, across, [0.0]), axis=-1).reshape(-1, 3)
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[2, 3] = 1.0
    K = np.array([[500.0, 0.0, 49.5], [0.0, 500.0, 49.5], [0.0, 0.0, 1.0]])
    image = DepthImage(np.ones((100, 100)), K, np.zeros((100, 100), dtype=np.int64), pose)
    places = np.array([[0.02, 0.0, 0.5], [0.2, 0.0, 0.5]])
    assert FreeSpace({"seen": wall}, pose[None, :3, 3]).empty(places).tolist() == [True, True]
    assert FreeSpace({"seen": wall}, pose[None, :3, 3], [image]).empty(places).tolist() == [True, False]


def test_a_hidden_contact_carries_what_nothing_seen_does():
    statics = Statics.of(rendered([(LOW, (0.0, 0.0, 0.0)), (BESIDE, (0.13, 0.0, 0.0))], 1))
    assert {frozenset((c.a, c.b)) for c in statics.contacts} == {
        frozenset(("table", "low")),
        frozenset(("table", "beside")),
    }
    assert max(statics.unexplained.values()) < 0.1
