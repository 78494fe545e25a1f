from collections.abc import Iterator

import numpy as np
import pytest
import trimesh

from topple.planner.decide.dependency import dependencies
from topple.planner.execution.look import Observer
from topple.robots import scenario
from topple.robots.scenarios.scenario import Scenario, pose_at
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera, Noise
from topple.robots.world.world import World
from topple.topology.io.load import load_scene
from topple.topology.relations.inferred import MEET
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage


@pytest.fixture(scope="module")
def pile() -> Iterator[Scenario]:
    with scenario("pile", 702) as stage:
        yield stage


def looks(pile: Scenario, off: float) -> list[DepthImage]:
    rng = np.random.default_rng(2)
    return [camera.with_mask_noise(off, missing=0.0).look(pile.world, rng) for camera in pile.cameras]


def test_what_is_given_to_another_was_wrong_and_few_that_lie_beside_their_object_are_left(pile):
    for true, seen in zip(looks(pile, 0.0), looks(pile, 1.0), strict=True):
        wrong = (seen.label != true.label) & (seen.depth > 0)
        given = (seen.borders.owner != seen.label) & (seen.borders.owner >= 0)
        assert (given & (seen.borders.owner == true.label)).sum() > 0.75 * given.sum()
        assert (wrong & (seen.borders.owner == seen.label)).sum() < 0.4 * wrong.sum()


def test_what_depends_on_what_is_as_with_exact_masks():
    def found(off: float) -> tuple[set[tuple[str, str]], tuple[str, ...]]:
        with scenario("pile", 704) as pile:
            cameras = [camera.with_mask_noise(off, missing=0.0) for camera in pile.cameras]
            look = Observer(pile.world, cameras, np.random.default_rng(2), pile.fixed).look()
        edges = dependencies(look.situation, direct=False).dependencies
        return {(edge.first, edge.then) for edge in edges}, look.faults

    (exact, silent), (off, said) = found(0.0), found(1.0)
    assert off == exact and len(exact) == 4 and silent == ()
    assert [text.split(":")[0] for text in said] == ["camera 1", "camera 2", "camera 3"]


@pytest.mark.parametrize("off", [0.0, 2.0])
def test_a_frame_whose_masks_are_off_says_so_as_it_is_read(pile, tmp_path, off):
    seen = looks(pile, off)[0]
    np.savez(tmp_path / "frame.npz", depth=seen.depth, K=seen.K, label=seen.label)
    said = [note for note in load_scene(tmp_path / "frame.npz").assumptions if "masks are off" in note]
    assert len(said) == (off > 0.0)


@pytest.mark.parametrize(("gap", "reason"), [(0.0, MEET), (0.006, None)])
def test_balls_side_by_side_meet_where_no_depth_comes_back_between_them(gap, reason):
    round_ = trimesh.creation.icosphere(3, 0.04).vertices
    with World() as world:
        world.add_table()
        for name, side in (("left", -1), ("right", 1)):
            world.add(Body.of(name, [round_], mass=0.2), pose_at(side * (0.04 + gap / 2), 0.0, 0.04))
        loses_edges = Noise(edge_loss=0.9)
        camera = Camera.looking_at((0.0, -0.6, 0.5), (0, 0, 0.03), width=480, height=360, noise=loses_edges)
        image = camera.look(world, np.random.default_rng(0))
    pair = relate(Scene.from_images([image], fixed=["table"])).between("left", "right")
    assert pair.reason == reason and pair.inferred == (reason is not None), pair
