"""What of a table top is free, seen from straight above: distances by cell, edges, ways out, boards above."""

from collections.abc import Sequence

import numpy as np
import pytest

from topple.planner.placement.free_space import FreeSpace, free_spaces
from topple.planner.placement.resting import PLACEMENT_TOLERANCES
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import Solids
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

UP = (0.0, 0.0, 1.0)
HALF = 0.4  # [m] of the table's edge
CELL, EDGE = PLACEMENT_TOLERANCES.cell, PLACEMENT_TOLERANCES.edge


def sheet(half: float = HALF, height: float = 0.0, spacing: float = 0.008) -> FloatArray:
    axis = np.arange(-half, half + spacing / 2, spacing)
    x, y = np.meshgrid(axis, axis)
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])


def block(x: float, y: float, side: float, height: float, low: float = 0.0) -> list[FloatArray]:
    """The one part of an upright block about (x, y) [m]."""
    h = side / 2
    return [np.array([[x + a, y + b, low + c] for a in (-h, h) for b in (-h, h) for c in (0.0, height)])]


def spaces(bodies: Solids, fixed: Sequence[str] = ("table",), **options: object) -> tuple[FreeSpace, ...]:
    """Of a table and blocks on it; clouds are the corners of the bodies."""
    solids = {"table": block(0.0, 0.0, 2 * HALF, -0.02), **bodies}
    clouds = {"table": sheet(), **{name: np.vstack(parts) for name, parts in bodies.items()}}
    return free_spaces(Situation(Scene(clouds, fixed=fixed, up=UP), known_solids=solids), **options)  # type: ignore[arg-type]


def at(space: FreeSpace, x: float, y: float) -> float:
    """Distance of the cell at a place of the table to what is not free [m]."""
    i, j = cell_of(space, x, y)
    return float(space.distance[i, j])


def cell_of(space: FreeSpace, x: float, y: float) -> tuple[int, int]:
    """Indices of the cell whose middle is nearest to a place in the world [m]; axes are those of the map."""
    cells = np.argwhere(np.ones(space.distance.shape, dtype=bool))
    axes = level(space)
    nearest = np.linalg.norm(space.middles(cells) - axes @ np.array([x, y, 0.0]), axis=1).argmin()
    return int(cells[nearest, 0]), int(cells[nearest, 1])


def level(space: FreeSpace) -> FloatArray:
    from topple.topology.geometry.axes import level_axes

    return np.stack(level_axes(space.normal))


def test_an_empty_table_is_free_but_for_its_edge():
    (space,) = spaces({})
    assert (space.owner, space.cell) == ("table", CELL)
    assert space.height == pytest.approx(0.0, abs=1e-9)
    assert space.normal == pytest.approx(UP)
    assert at(space, 0.0, 0.0) == pytest.approx(HALF - EDGE, abs=1.5 * CELL)
    assert at(space, HALF - EDGE - 0.1, 0.0) == pytest.approx(0.1, abs=1.5 * CELL)
    assert at(space, HALF - 0.5 * EDGE, 0.0) == 0.0, "so close to the edge a thing may tip over it"
    assert at(space, HALF - EDGE - 1.5 * CELL, 0.0) > 0.0
    free = np.count_nonzero(space.distance > 0.0) * CELL**2
    assert free == pytest.approx((2 * (HALF - EDGE)) ** 2, rel=0.08)
    assert not space.ways.any()


def test_what_stands_on_the_table_is_as_far_as_it_is():
    (space,) = spaces({"block": block(0.1, 0.05, 0.1, 0.08)})
    assert at(space, 0.1, 0.05) == 0.0
    assert at(space, 0.1, 0.05 + 0.05 + 0.06) == pytest.approx(0.06, abs=1.5 * CELL)
    assert at(space, 0.1 - 0.05 - 0.1, 0.05) == pytest.approx(0.1, abs=1.5 * CELL)


def test_what_is_to_be_moved_leaves_its_place_free():
    bodies = {"block": block(0.1, 0.05, 0.1, 0.08)}
    (left_out,), (empty,) = spaces(bodies, leave_out=["block"]), spaces({})
    assert np.array_equal(left_out.distance, empty.distance)


def test_a_place_to_keep_free_is_not_free():
    (space,) = spaces({}, avoid=[block(-0.1, 0.1, 0.06, 0.05)[0]])
    assert at(space, -0.1, 0.1) == 0.0
    assert at(space, -0.1, 0.1 - 0.03 - 0.05) == pytest.approx(0.05, abs=1.5 * CELL)


def test_half_an_open_hand_around_what_is_still_to_be_taken_is_on_its_way_out():
    reach = PLACEMENT_TOLERANCES.good_gap
    (space,) = spaces({"block": block(0.0, 0.0, 0.06, 0.05)}, remaining=["block"])
    assert space.ways[cell_of(space, 0.0, 0.0)]
    assert space.ways[cell_of(space, 0.03 + reach - 2 * CELL, 0.0)]
    assert not space.ways[cell_of(space, 0.03 + reach + 2 * CELL, 0.0)]
    (other,) = spaces({"block": block(0.0, 0.0, 0.06, 0.05)})
    assert not other.ways.any(), "nothing is still to be taken"


@pytest.mark.parametrize(("tall", "free"), [(0.05, True), (0.15, False)])
def test_below_a_board_it_is_free_for_what_fits_with_a_hand(tall, free):
    low = 0.05 + PLACEMENT_TOLERANCES.headroom + 0.05
    x, y = np.meshgrid(np.arange(-0.1, 0.11, 0.01), np.arange(-0.1, 0.11, 0.01))
    board = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, low)])
    solids = {"table": block(0.0, 0.0, 2 * HALF, -0.02), "board": block(0.0, 0.0, 0.2, 0.02, low)}
    scene = Scene({"table": sheet(), "board": board}, fixed=["table", "board"], up=UP)
    below = next(
        one for one in free_spaces(Situation(scene, known_solids=solids), tall=tall) if one.owner == "table"
    )
    assert (at(below, 0.0, 0.0) > 0.0) is free


def test_a_scene_without_a_fixed_surface_has_no_free_space():
    assert spaces({"block": block(0.0, 0.0, 0.06, 0.05)}, fixed=()) == ()


def test_what_covers_some_cells_has_the_least_distance_of_them_and_none_beyond_the_map():
    (space,) = spaces({"block": block(0.1, 0.05, 0.1, 0.08)}, remaining=["block"])
    covered = np.array([[0, 0], [1, 0], [0, -2]])
    cells = np.argwhere(space.distance > 0.05)[::37]
    assert len(cells) > 20
    distance, barred = space.under(cells, covered)
    for cell, found, bars in zip(cells, distance, barred, strict=True):
        i, j = (cell + covered).T
        assert found == space.distance[i, j].min()
        assert bars == space.ways[i, j].any()
    corner, _ = space.under(np.array([[0, 0]]), np.array([[-3, 0]]))
    assert corner.tolist() == [0.0]


def test_a_turned_world_has_the_same_free_space():
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])
    solids = {"table": block(0.0, 0.0, 2 * HALF, -0.02), "block": block(0.1, 0.05, 0.1, 0.08)}
    clouds = {"table": sheet(), "block": np.vstack(solids["block"])}
    turned = {name: cloud @ turn.T for name, cloud in clouds.items()}
    parts = {name: [part @ turn.T for part in found] for name, found in solids.items()}
    (plain,) = free_spaces(Situation(Scene(clouds, fixed=["table"], up=UP), known_solids=solids))
    (tilted,) = free_spaces(Situation(Scene(turned, fixed=["table"], up=turn[:, 2]), known_solids=parts))
    area = [np.count_nonzero(space.distance > 0.05) * CELL**2 for space in (plain, tilted)]
    assert tilted.normal == pytest.approx(turn[:, 2])
    assert area[0] > 0.2
    assert area[1] == pytest.approx(area[0], rel=0.05)
