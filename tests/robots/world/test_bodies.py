"""Bodies from parts, meshes, files and clouds."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from topple.benchmarks.body_files import body_from_files
from topple.robots import shapes
from topple.robots.collision.rounding import cores
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.bodies import Body
from topple.robots.world.world import World
from topple.topology.base.errors import InvalidInput

YCB = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "ycb"


def cuboid(size: tuple[float, float, float]) -> np.ndarray:
    half = np.array(size) / 2
    return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half


def test_mass_properties_of_a_cuboid_are_the_textbooks():
    body = Body.of("box", [cuboid((0.1, 0.2, 0.3)) + np.array([1, 2, 3])], density=500)
    assert body.mass == pytest.approx(0.1 * 0.2 * 0.3 * 500)
    np.testing.assert_allclose(body.centre_of_mass, [1, 2, 3])
    squares = np.array([0.2**2 + 0.3**2, 0.1**2 + 0.3**2, 0.1**2 + 0.2**2])
    np.testing.assert_allclose(body.inertia, np.diag(body.mass * squares / 12), atol=1e-12)


def test_two_halves_weigh_as_the_whole():
    whole = Body.of("box", [cuboid((0.2, 0.1, 0.05))])
    half = cuboid((0.1, 0.1, 0.05))
    parts = Body.of("box", [half - [0.05, 0, 0], half + np.array([0.05, 0, 0])])
    assert parts.mass == pytest.approx(whole.mass)
    np.testing.assert_allclose(parts.centre_of_mass, whole.centre_of_mass, atol=1e-12)
    np.testing.assert_allclose(parts.inertia, whole.inertia, atol=1e-12)


def test_a_body_is_refused_without_parts_or_mass():
    with pytest.raises(InvalidInput, match="'nothing' has no parts"):
        Body.of("nothing", [])
    with pytest.raises(InvalidInput, match=r"mass of -1(\.0)? kg"):
        Body.of("balloon", [cuboid((0.1, 0.1, 0.1))], mass=-1.0)


def test_a_flat_part_gets_a_thickness():
    sheet = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]])
    body = Body.of("sheet", [sheet], mass=0.01)
    assert 0 < body.upper[2] - body.lower[2] < 1e-3


def test_rounding_leaves_faces_where_they_are_and_seams_closed():
    for body in (shapes.box(), shapes.plate(), shapes.spoon(), shapes.mug(), shapes.orange()):
        core = cores(body.parts)
        assert 1e-4 < core.margin <= 1e-3
        lower = np.min([part.min(axis=0) for part in core.parts], axis=0) - core.margin
        upper = np.max([part.max(axis=0) for part in core.parts], axis=0) + core.margin
        np.testing.assert_allclose(lower[2], body.lower[2], atol=4e-4)
        np.testing.assert_allclose(upper[2], body.upper[2], atol=4e-4)
        volume = sum(trimesh.convex.convex_hull(part).volume for part in core.parts)
        assert 0 < volume < body.mass / 300


def test_two_boxes_side_by_side_keep_their_seam():
    box = cuboid((0.1, 0.1, 0.1))
    left, right = cores([box - [0.05, 0, 0], box + np.array([0.05, 0, 0])]).parts
    assert left[:, 0].max() == pytest.approx(0.0, abs=1e-9)
    assert right[:, 0].min() == pytest.approx(0.0, abs=1e-9)
    assert left[:, 2].max() == pytest.approx(0.049, abs=1e-9)


@pytest.mark.skipif(not YCB.is_dir(), reason="../shared/data/ycb, published objects, is absent")
@pytest.mark.parametrize("name", ["024_bowl", "011_banana", "005_tomato_soup_can"])
def test_a_published_object_rests_where_its_files_say(name):
    body = body_from_files(YCB / name)
    with World() as world:
        world.add_table()
        world.add(body, pose_at(0, 0, 0.001))
        assert world.settle(3.0)
        assert abs(world.pose(name)[2, 3]) < 0.004


def test_a_folder_without_parts_is_refused_by_name(tmp_path):
    with pytest.raises(InvalidInput, match=r"collision\.obj"):
        body_from_files(tmp_path)
    (tmp_path / "collision.obj").write_text("o part0\nv 1 2 three\n")
    with pytest.raises(InvalidInput, match="cannot be read as a Wavefront file"):
        body_from_files(tmp_path)
    (tmp_path / "collision.obj").write_text("o part0\nv 0 0 0\n")
    with pytest.raises(InvalidInput, match="no part of four vertices"):
        body_from_files(tmp_path)
