import pytest
from moving import at as pose

from topple.robots import shapes
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology.relations.facing import settled_share
from topple.topology.relations.relate import relate
from topple.topology.relations.surface import SurfaceCloud
from topple.topology.scene.scene import Scene
from topple.topology.sixim.confidence import Evidence, confidence
from topple.topology.sixim.table import Relation
from topple.topology.views.free_space import FreeSpace


def rendered(bodies, *eyes):
    """Bodies put where they are told, not let go, as depth cameras see them."""
    with World() as world:
        world.add_table(size=(0.8, 0.8))
        for body, place in bodies:
            world.add(body, pose(*place), fixed=True)
        images = [Camera.looking_at(eye, (0.0, 0.0, 0.05)).look(world) for eye in eyes]
    return Scene.from_images(images, fixed=["table"], up=(0, 0, 1))


ABOVE, BESIDE, FRONT = (0.05, 0.0, 0.8), (0.8, 0.1, 0.05), (0.6, 0.0, 0.45)


def test_the_underside_of_a_lifted_plate_is_seen_from_beside_and_not_from_above():
    plate = shapes.box("plate", (0.2, 0.2, 0.02))
    for eye, seen in ((ABOVE, False), (BESIDE, True)):
        pair = relate(rendered([(plate, (0, 0, 0.06))], eye)).between("plate", "table")
        assert pair.observed is seen
        assert pair.inferred is not seen  # nothing holds it up but what cannot be seen


def test_a_support_hidden_below_an_overhang_is_not_called_observed():
    block, lid = shapes.box("block", (0.1, 0.1, 0.05)), shapes.box("lid", (0.24, 0.24, 0.02))
    foot = shapes.box("foot", (0.2, 0.06, 0.02))
    bodies = [(foot, (0.0, 0.0, 0.0)), (block, (0, 0, 0.02)), (lid, (0.0, 0, 0.07))]
    above, beside = (
        relate(rendered(bodies, eye)).between("lid", "table") for eye in ((0.35, 0, 0.8), BESIDE)
    )
    assert not above.observed
    assert beside.observed, "from beside one sees that there is none"


def test_a_gap_in_plain_sight_is_observed():
    scene = rendered([(shapes.box("left", (0.08, 0.08, 0.08)), (0, -0.075, 0)),
                      (shapes.box("right", (0.08, 0.08, 0.08)), (0, 0.075, 0))], FRONT, ABOVE)  # fmt: skip
    pair = relate(scene).between("left", "right")
    assert pair.relation is Relation.DISJOINT
    assert pair.observed
    assert pair.gap == pytest.approx(0.07, abs=0.01)


def test_what_stands_behind_an_object_may_touch_it():
    front, back = shapes.box("front", (0.04, 0.2, 0.16)), shapes.box("back", (0.08, 0.1, 0.2))
    scene = rendered([(front, (0.1, 0, 0)), (back, (0.0, 0, 0))], (0.8, 0, 0.25))
    pair = relate(scene).between("front", "back")
    assert pair.relation is Relation.DISJOINT
    assert not pair.observed
    assert pair.confidence == confidence(Evidence.APART_UNSEEN, 1, pair.gap)


def test_what_is_seen_does_not_depend_on_which_object_is_named_first():
    scene = rendered(
        [(shapes.can("can"), (0, 0, 0.03)), (shapes.box("box", (0.1, 0.1, 0.05)), (0.1, 0, 0))], FRONT
    )
    sight = FreeSpace(scene.clouds, scene.viewpoints, scene.images)
    one, other = (SurfaceCloud.of(name, scene.clouds[name]) for name in ("can", "box"))
    assert settled_share(one, other, sight) == settled_share(other, one, sight)
