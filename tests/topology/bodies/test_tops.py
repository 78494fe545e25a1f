import numpy as np
import pytest
import trimesh

from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.tops import Tops, lowest_in_use, tops_of

UP = np.array([0.0, 0.0, 1.0])


def surface(*boxes: tuple[tuple[float, float, float], tuple[float, float, float]]) -> FloatArray:
    """Points on the surfaces of boxes of given sizes and middles."""
    made = [trimesh.creation.box(size, trimesh.transformations.translation_matrix(at)) for size, at in boxes]
    return np.asarray(trimesh.util.concatenate(made).sample(20_000, seed=0))


def heights(found: Tops) -> list[float]:
    return [round(float(top.points.mean(axis=0) @ UP), 2) for top in found.tops]


@pytest.mark.parametrize("noise", [0.0, 0.001])
@pytest.mark.parametrize("thickness", [0.006, 0.01, 0.02, 0.04, 0.3])
def test_a_board_has_one_top_however_thick_it_is(thickness, noise):
    cloud = surface(((0.8, 0.6, thickness), (0, 0, -thickness / 2)))
    found = tops_of(cloud + np.random.default_rng(0).normal(0.0, noise, cloud.shape), UP)
    (top,) = found.tops
    assert top.height == pytest.approx(0.0, abs=0.001)
    assert top.thickness == pytest.approx(thickness, abs=0.0015)
    assert not top.walled


def test_a_sheet_seen_through_noise_is_one_surface_with_all_its_points():
    rng = np.random.default_rng(0)
    cloud = np.column_stack([rng.uniform(-0.5, 0.5, (5000, 2)), rng.normal(0.0, 0.003, 5000)])
    found = tops_of(cloud, UP)
    assert found.flat
    assert found.tops[0].points is cloud


def test_a_table_has_legs_but_no_top_below_its_board():
    legs = [((0.06, 0.06, 0.7), (x, y, 0.35)) for x in (-0.5, 0.5) for y in (-0.3, 0.3)]
    assert heights(tops_of(surface(((1.2, 0.8, 0.03), (0, 0, 0.715)), *legs), UP)) == [0.73]


def test_every_board_of_a_shelf_is_a_top_and_its_walls_are_none():
    boards = [((0.8, 0.35, 0.02), (0.0, 0.0, z - 0.01)) for z in (0.0, 0.3, 0.6)]
    walls = [((0.02, 0.35, 0.6), (x, 0.0, 0.3)) for x in (-0.41, 0.41)]
    found = tops_of(surface(*boards, *walls, ((0.8, 0.02, 0.6), (0, 0.185, 0.3))), UP)
    assert heights(found) == [0.6, 0.3, 0.0]
    assert [round(top.thickness, 2) for top in found.tops] == [0.02, 0.02, 0.02]
    cup = np.array([[0.1, 0.0, 0.31], [0.1, 0.0, 0.38]])
    under = found.under(cup)
    assert under is not None and under.height == pytest.approx(0.3, abs=0.002)
    assert lowest_in_use(found.tops, [cup]).height == pytest.approx(0.3, abs=0.002)


def test_the_floor_of_a_bin_is_walled_and_its_rim_no_top():
    walls = [((0.3, 0.01, 0.1), (0, y, 0.05)) for y in (-0.1, 0.1)]
    walls += [((0.01, 0.2, 0.1), (x, 0, 0.05)) for x in (-0.15, 0.15)]
    (top,) = tops_of(surface(((0.3, 0.2, 0.01), (0, 0, -0.005)), *walls), UP).tops
    assert top.walled
    assert top.height == pytest.approx(0.0, abs=0.002)


@pytest.mark.parametrize("shape", ["ball", "wall"])
def test_what_nothing_stands_on_has_no_top(shape):
    ball = np.asarray(trimesh.creation.icosphere(radius=0.1).sample(5000, seed=0))
    cloud = ball if shape == "ball" else surface(((0.8, 0.02, 0.8), (0, 0, 0.4)))
    assert tops_of(cloud, UP).tops == ()


def test_a_tilted_up_turns_the_tops_with_it():
    turn = trimesh.transformations.rotation_matrix(0.6, [1, 0, 0])[:3, :3]
    cloud = surface(((0.8, 0.6, 0.04), (0, 0, -0.02))) @ turn.T
    (top,) = tops_of(cloud, turn @ UP).tops
    assert top.normal @ turn @ UP == pytest.approx(1.0, abs=1e-4)
    assert top.height == pytest.approx(0.0, abs=0.001)
