"""Things that no mask names: one on a crate is there all the same, a wall or a cable is no thing to take."""

import numpy as np
import pytest

from topple.planner import order
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage

CRATE, CARTON, CAN = (
    shapes.box("crate", (0.16, 0.12, 0.08)), shapes.box("carton", (0.08, 0.06, 0.1)), shapes.can("can"),
)  # fmt: skip
WALL, POST, CABLE, SHELF = (
    shapes.box("wall", (0.02, 1.2, 0.8)), shapes.box("post", (0.03, 0.03, 0.7)),
    shapes.box("cable", (0.006, 0.5, 0.006)), shapes.box("shelf", (0.3, 0.9, 0.05)),
)  # fmt: skip
AROUND = {
    "wall": (-0.35, 0.0, 0.0),
    "post": (-0.05, 0.3, 0.0),
    "cable": (0.1, 0.0, 0.0),
    "shelf": (-0.6, 0, 0.25),
}
BODIES = {"crate": (0, 0, 0), "carton": (0.02, 0, 0.08), "can": (0.02, 0.2, 0.0)}
EYES = ((0.5, 0.1, 0.55), (0.35, -0.4, 0.5), (0.3, 0.35, 0.6))


@pytest.fixture(scope="module")
def images() -> list[DepthImage]:
    with World() as world:
        world.add_table(size=(1.4, 1.4))
        for body in (CRATE, CARTON, CAN, WALL, POST, CABLE, SHELF):
            world.add(body, pose_at(*(BODIES | AROUND)[body.name]), fixed=True)
        rng = np.random.default_rng(0)
        return [Camera.looking_at(eye, (0.0, 0.05, 0.05)).look(world, rng) for eye in EYES]


def without_masks(image: DepthImage, *names: str) -> DepthImage:
    numbers = [number for number, name in image.names.items() if name in names]
    label = np.where(np.isin(image.label, numbers), 0, image.label)
    kept = {number: name for number, name in image.names.items() if name not in names}
    return DepthImage(image.depth, image.K, label, image.pose_camera_to_world, kept)


ALONE = (pytest.param(slice(k, k + 1), marks=pytest.mark.slow) for k in (1, 2))


@pytest.mark.parametrize("cameras", [slice(0, 1), *ALONE, slice(0, 3)])
def test_what_stands_around_is_no_thing_and_a_thing_without_a_mask_is_one(images, cameras):
    seen = [without_masks(image, *AROUND) for image in images[cameras]]
    assert Scene.from_images(seen, fixed=["table"], up=(0, 0, 1)).movable == ("crate", "carton", "can")
    blind = [without_masks(image, "carton") for image in seen]
    scene = Scene.from_images(blind, fixed=["table"], up=(0, 0, 1))
    assert scene.movable == ("crate", "can", "unnamed_1")
    said = "something without a name is at crate: 'unnamed_1'; take it away, or name it"
    assert said in scene.assumptions
    assert order(scene, ["crate"]).order == ("unnamed_1", "crate")
    assert order(scene, ["can"]).order == ("can",)
    alone = Scene.from_images(blind, fixed=["table"], up=(0, 0, 1), unnamed=False)
    assert alone.movable == ("crate", "can")


def test_a_thing_without_a_mask_is_seen_below_the_top_of_what_never_moves(images):
    seen = [
        without_masks(image, "wall", "cable", "shelf", "carton") for image in images
    ]  # the post is 70 cm high
    scene = Scene.from_images(seen, fixed=["table", "post"], up=(0, 0, 1))
    assert scene.movable == ("crate", "can", "unnamed_1")
    assert order(scene, ["crate"]).order == ("unnamed_1", "crate")


def test_what_one_picture_has_no_mask_of_is_what_the_others_say(images):
    seen = [without_masks(image, *AROUND) for image in images]
    whole = Scene.from_images(seen, fixed=["table"], up=(0, 0, 1))
    for name in ("carton", "can"):
        mended = Scene.from_images([without_masks(seen[0], name), *seen[1:]], fixed=["table"], up=(0, 0, 1))
        assert set(mended.movable) == set(whole.movable) and len(mended.matter) == pytest.approx(
            len(whole.matter), rel=0.01
        )
        assert len(mended.clouds[name]) > 0.9 * len(whole.clouds[name])
        assert (
            f"a picture that shows {name!r} has no mask of it: its points are taken for it"
            in mended.assumptions
        )


def test_a_name_that_is_taken_is_not_given_again(images):
    blind = without_masks(images[0], "carton", *AROUND)
    names = {n: {"can": "unnamed_1"}.get(name, name) for n, name in blind.names.items()}
    renamed = DepthImage(blind.depth, blind.K, blind.label, blind.pose_camera_to_world, names)
    scene = Scene.from_images([renamed], fixed=["table"], up=(0, 0, 1))
    assert scene.movable == ("crate", "unnamed_1", "unnamed_1_2")


def test_what_is_to_be_ignored_is_neither_thing_nor_matter(images):
    seen = without_masks(images[0], *AROUND)
    hidden = images[0].label * np.isin(
        images[0].label, [n for n, v in images[0].names.items() if v in AROUND]
    )
    label, number = np.where(hidden > 0, 99, seen.label), {99: "ignore"}
    image = DepthImage(seen.depth, seen.K, label, seen.pose_camera_to_world, {**seen.names, **number})
    scene = Scene.from_images([image], fixed=["table"], up=(0, 0, 1))
    assert scene.movable == ("crate", "carton", "can")
    assert len(Scene.from_images([seen], fixed=["table"], up=(0, 0, 1)).matter) > 1000
    assert len(scene.matter) < 50
