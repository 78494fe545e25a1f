"""Masks wrong in kind, as rendered cameras see them: each is said, and true masks are not."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.planner import order
from topple.planner.report.show import show_page
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology import InvalidInput, relate
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage
from topple.topology.views.wrong_masks import MaskFault

BODIES = {
    shapes.box("crate", (0.16, 0.12, 0.08)): (0, 0, 0),
    shapes.box("carton", (0.08, 0.06, 0.1)): (0.02, 0, 0.08),
    shapes.can("can"): (0.02, 0.25, 0.0),
    shapes.box("post", (0.04, 0.04, 0.14)): (0.16, 0.02, 0.0),
}
EYES = ((0.5, 0.1, 0.55), (0.35, -0.4, 0.5))


@pytest.fixture(scope="module")
def images() -> list[DepthImage]:
    with World() as world:
        world.add_table(size=(1.4, 1.4))
        for body, at in BODIES.items():
            world.add(body, pose_at(*at), fixed=True)
        rng = np.random.default_rng(0)
        return [Camera.looking_at(eye, (0.0, 0.05, 0.05)).look(world, rng) for eye in EYES]


def number(image: DepthImage, name: str) -> int:
    return next(k for k, called in image.names.items() if called == name)


def split(image: DepthImage) -> DepthImage:
    """The can in two masks, left and right."""
    own = image.label == number(image, "can")
    columns = np.indices(own.shape)[1]
    label = np.where(own & (columns > np.median(columns[own])), 90, image.label)
    return replace(image, label=label, names={**image.names, 90: "part"})


def merged(image: DepthImage) -> DepthImage:
    """The post and the crate behind it in one mask."""
    crate, post = number(image, "crate"), number(image, "post")
    names = {k: name for k, name in image.names.items() if k != post}
    return replace(image, label=np.where(image.label == post, crate, image.label), names=names)


def level(image: DepthImage) -> DepthImage:
    """A mask on the bare table."""
    rows, columns = np.nonzero(image.label == number(image, "table"))
    middle = len(rows) // 2
    rr, cc = np.indices(image.label.shape)
    label = image.label.copy()
    blob = (rr - rows[middle]) ** 2 + (cc - columns[middle]) ** 2 < 150
    label[blob & (image.label == number(image, "table"))] = 90
    return replace(image, label=label, names={**image.names, 90: "ghost"})


def scene(*images: DepthImage) -> Scene:
    return Scene.from_images(images, fixed=["table"])


def test_true_masks_are_silent(images):
    assert scene(*images).wrong_masks == ()


@pytest.mark.parametrize(
    ("spoil", "eye", "names", "words"),
    [
        (split, 0, ("can", "part"), "one smooth surface"),
        (merged, 0, ("crate",), "two objects in one mask"),
        (level, 0, ("ghost",), "level with what carries it"),
    ],
)
def test_each_kind_is_said_once(images, spoil, eye, names, words):
    found = scene(spoil(images[eye]))
    assert [wrong.names for wrong in found.wrong_masks] == [names]
    assert [words in text for text in found.assumptions].count(True) == 1


def test_one_object_under_two_names_is_said(images):
    one, other = images
    names = {k: "tin" if name == "can" else name for k, name in other.names.items()}
    found = scene(one, replace(other, names=names))
    assert [wrong.names for wrong in found.wrong_masks] == [("can", "tin")]


def seen(bodies: dict[Body, FloatArray], eye: tuple[float, float, float] = (0.4, 0.1, 0.4)) -> DepthImage:
    with World() as world:
        world.add_table(size=(1.4, 1.4))
        for body, pose in bodies.items():
            world.add(body, pose, fixed=True)
        return Camera.looking_at(eye, (0.0, 0.0, 0.04)).look(world, np.random.default_rng(0))


STANDING = pose_at(0, 0, 0.11, Rotation.from_euler("y", 80, degrees=True))
HOLLOW = {
    "a cup alone": {shapes.cup("cup"): pose_at(0, 0, 0)},
    "a spoon in a bowl": {
        shapes.bowl("bowl"): pose_at(0, 0, 0),
        shapes.spoon("spoon"): pose_at(0.02, 0, 0.03, Rotation.from_euler("y", -30, degrees=True)),
    },
    "a plate in a rack": {
        shapes.plate("plate"): STANDING,
        shapes.box("left", (0.12, 0.02, 0.05)): pose_at(0, -0.06, 0),
        shapes.box("right", (0.12, 0.02, 0.05)): pose_at(0, 0.06, 0),
    },
}


@pytest.mark.parametrize("bodies", HOLLOW.values(), ids=HOLLOW)
def test_true_masks_of_what_is_hollow_are_silent(bodies):
    assert scene(seen(bodies)).wrong_masks == ()


def test_boxes_flush_side_by_side_are_said_at_most_and_never_refused():
    bodies = {shapes.box(name, (0.08, 0.08, 0.08)): pose_at(0, y, 0) for name, y in (("a", 0), ("b", 0.08))}
    found = scene(seen(bodies))
    assert {wrong.fault for wrong in found.wrong_masks} <= {MaskFault.SPLIT}
    assert not any(wrong.refuses for wrong in found.wrong_masks)
    assert order(found, "a").order == ("a",)


def test_masks_of_what_never_moves_are_not_asked_about(images):
    found = Scene.from_images([split(images[0])], fixed=["table", "can", "part"])
    assert found.wrong_masks == ()


def test_labels_of_any_size_are_names(images):
    ghost = level(images[0])
    large = replace(ghost, label=np.where(ghost.label == 90, 2**62, ghost.label), names={
        **{k: name for k, name in ghost.names.items() if k != 90}, 2**62: "ghost"
    })  # fmt: skip
    assert [wrong.names for wrong in scene(large).wrong_masks] == [("ghost",)]


def test_larger_pictures_tell_the_same(images):
    small = level(images[0])
    scale = np.diag([2.0, 2.0, 1.0])
    depth, label = (each.repeat(2, axis=0).repeat(2, axis=1) for each in (small.depth, small.label))
    large = replace(small, depth=depth, label=label, K=scale @ small.K, rgb=None)
    assert scene(large).wrong_masks == scene(small).wrong_masks != ()


def test_a_target_that_hangs_on_a_mask_on_nothing_is_refused(images):
    found = scene(level(images[0]))
    with pytest.raises(InvalidInput, match=r"'ghost' is level.*--masks-as-they-are"):
        order(found, "ghost")
    assert order(found, "crate").order == ("carton", "crate")
    assert "ghost" in order(found).order


def test_masks_as_they_are_are_said_and_not_refused(images):
    found = scene(level(images[0])).with_masks_as_they_are()
    assert order(found, "ghost").order == ("ghost",)
    assert [wrong.names for wrong in pickle.loads(pickle.dumps(found)).wrong_masks] == [("ghost",)]
    assert any("level with what carries it" in text for text in found.assumptions)


@pytest.mark.parametrize("spoil", [split, merged])
def test_what_true_masks_may_look_like_is_said_and_never_refused(images, spoil):
    found = scene(spoil(images[0]))
    assert found.wrong_masks
    for name in found.movable:
        assert name in order(found, name).order


def page(found: Scene) -> str:
    return show_page(found, relate(found))


def test_a_page_marks_wrong_masks_in_the_picture(images):
    ghost = level(images[0])
    drawn = replace(ghost, rgb=np.full((*ghost.label.shape, 3), 128, dtype=np.uint8))
    assert "Wide outline: the mask of &#x27;ghost&#x27; is level" in page(scene(drawn))
    assert "Wide outline" not in page(scene(replace(images[0], rgb=drawn.rgb)))
