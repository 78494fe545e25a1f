import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import random_array

from topple.topology.base.arrays import bounds
from topple.topology.bodies.parts import convex_parts
from topple.topology.geometry.hull import Hull
from topple.topology.kernels import build, compiled
from topple.topology.kernels.cavity import wall_above, wall_around
from topple.topology.kernels.cells import cells_of, turned_bounds, within_reach
from topple.topology.kernels.closest import closest_places
from topple.topology.kernels.continued import continue_surfaces, planes_around
from topple.topology.kernels.heights import heights_over
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.outline import outline_corners
from topple.topology.kernels.pieces import pieces_of_links
from topple.topology.kernels.planes import patch_planes
from topple.topology.kernels.spheres import sphere_nearest
from topple.topology.kernels.triangles import draw_triangles
from topple.topology.statics.holding import normal_sums
from topple.topology.views.borders import Picture

pytestmark = pytest.mark.skipif(compiled.kernels() is None, reason="no kernels were compiled here")

RNG = np.random.default_rng(0)
BALL = RNG.normal(size=(3000, 3))
CLOUDS = {
    "one": RNG.normal(size=(1, 3)),
    "few": RNG.normal(size=(3, 3)),
    "a leaf and one": RNG.normal(size=(17, 3)),
    "coincident": np.ones((40, 3)),
    "on a line": np.outer(np.linspace(0, 1, 300), [1.0, 2.0, 3.0]),
    "in a plane": RNG.normal(size=(500, 3)) * [1.0, 1.0, 0.0],
    "far away": RNG.normal(size=(200, 3)) * 1e-3 + 1e3,
    "with a stray": np.concatenate([RNG.normal(size=(900, 3)) * 0.01, [[50.0, 0.0, 0.0]]]),
    "grid": np.stack(np.meshgrid(*[np.arange(12.0)] * 3), axis=-1).reshape(-1, 3),
    "on a ball": BALL / np.linalg.norm(BALL, axis=1, keepdims=True),
    "in two axes": RNG.normal(size=(700, 2)),
}


@pytest.fixture
def both(monkeypatch):
    """What a call gives by the kernels, and by their twin."""

    def of(call, *given):
        found = []
        for path in ("", "numpy"):
            monkeypatch.setenv(compiled.VARIABLE, path)
            found.append(call(*given))
        return found

    return of


@pytest.mark.parametrize("name", CLOUDS)
@pytest.mark.parametrize("k", [1, 5, 12])
def test_neighbours_are_as_far_as_those_of_scipy(both, name, k):
    points = CLOUDS[name]
    ours, twin = both(PointTree, points)
    spread = max(float(np.ptp(points)), 1e-3)
    places = np.concatenate([points, points[:50] + RNG.normal(size=points[:50].shape) * spread])
    for bound in (np.inf, 0.3 * spread, 0.0):
        distances, rows = ours.query(places, k, bound)
        expected, _ = twin.query(places, k, bound)
        assert np.array_equal(distances, expected)
        there = rows < len(points)
        assert np.array_equal(there, np.isfinite(distances))
        asked = np.broadcast_to(places[:, None] if k > 1 else places, (*rows.shape, points.shape[1]))
        away = asked[there] - points[rows[there]]
        assert np.allclose(np.linalg.norm(away, axis=-1), distances[there], rtol=1e-14, atol=0)


def test_of_equally_near_points_the_first_of_the_cloud_counts():
    points = np.repeat(CLOUDS["grid"], 3, axis=0)
    assert np.array_equal(PointTree(points).query(points)[1], np.arange(len(points)) // 3 * 3)
    assert np.array_equal(PointTree(np.zeros((90, 3))).query(np.zeros((2, 3)), 4)[1], [[0, 1, 2, 3]] * 2)


@pytest.mark.parametrize("name", CLOUDS)
def test_what_is_within_a_radius_is_what_scipy_finds(both, name):
    points = CLOUDS[name]
    ours, twin = both(PointTree, points)
    radius = 0.21 * max(float(np.ptp(points)), 1e-3)
    found, expected = (tree.query_ball_point(points[::7], radius) for tree in (ours, twin))
    assert len(found) == len(points[::7]) > 0
    assert all(np.array_equal(one, other) for one, other in zip(found, expected, strict=True))
    pairs, others = (tree.query_pairs(radius) for tree in (ours, twin))
    assert np.array_equal(pairs[np.lexsort(pairs.T)], others[np.lexsort(others.T)])


@pytest.mark.parametrize("name", CLOUDS)
def test_a_look_around_every_point_is_that_of_scipy(both, name):
    points = CLOUDS[name]
    ours, twin = both(PointTree, points)
    weights = RNG.integers(1, 9, len(points)).astype(float)
    for radius in (0.21 * max(float(np.ptp(points)), 1e-3), 1e-9):
        (sums, distances, rows), expected = (tree.around(weights, radius, 7) for tree in (ours, twin))
        assert np.array_equal(sums, expected[0]) and np.array_equal(distances, expected[1])
        known, nearest = ours.query(points, 7)
        assert np.array_equal(distances, known) and np.array_equal(rows, nearest)


def test_pieces_are_numbered_by_their_first_rows(both):
    for count in (1, 2, 50, 2000):
        ours, twin = both(pieces_of_links, RNG.integers(0, count, (count // 2, 2)), count)
        assert np.array_equal(ours, twin)
    assert ours.max() > 500


def test_nothing_is_near_where_there_is_nothing(both):
    for tree in both(PointTree, np.empty((0, 3))):
        distances, rows = tree.query(np.zeros((2, 3)), 3)
        assert np.isinf(distances).all() and (rows == 0).all()
        assert [len(found) for found in tree.query_ball_point(np.zeros((2, 3)), 1.0)] == [0, 0]
        assert len(tree.query_pairs(1.0)) == 0
    for tree in both(PointTree, np.zeros((4, 3))):
        assert tree.query(np.empty((0, 3)), 2)[0].shape == (0, 2)
        assert tree.query(np.ones(3))[0] == np.sqrt(3)


@pytest.mark.parametrize("axes", [2, 3])
def test_spheres_are_those_of_least_squares(both, axes):
    found = 0
    for count in (4, 5, 30, 257, 2000):
        for _ in range(20):
            rays = RNG.normal(size=(count, axes))
            rays[:, 0] = np.abs(rays[:, 0])
            rays /= np.linalg.norm(rays, axis=1, keepdims=True)
            points = RNG.uniform(-1, 1, axes) + RNG.uniform(0.01, 0.3) * rays
            points += RNG.normal(scale=1e-3, size=points.shape)
            ours, twin = both(sphere_nearest, points, 2.5)
            assert (ours is None) == (twin is None)
            if ours is not None and twin is not None:
                found += 1
                assert np.abs(ours[0] - twin[0]).max() < 1e-7 > abs(ours[1] - twin[1])
    assert found > 80


@pytest.mark.parametrize("name", [name for name in CLOUDS if name != "in two axes"])
def test_cells_hold_the_same_points_and_have_the_same_means(both, name):
    points = CLOUDS[name]
    turn, edge = np.linalg.qr(RNG.normal(size=(3, 3)))[0], 0.1 * max(float(np.ptp(points)), 1e-3)

    def cut():
        lower, upper = bounds(points)
        cells = cells_of(points, lower - 1e-9, upper, edge)
        least, most = turned_bounds(points, turn)
        turned = cells_of(points, least - 1e-9, most, edge, turn)
        narrow = cells_of(points, lower - 1e-9, upper, 1e-4 * edge).order  # more of them than 32 bits count
        near = within_reach(points, points[0], 3 * edge)
        return cells, cells.means(), np.concatenate([least, most]), turned, narrow, near

    (ours, means, corners, turned, narrow, near), (twin, expected, others, other, thin, reached) = both(cut)
    assert np.array_equal(narrow, thin) and np.array_equal(near, reached) and near[0]
    assert np.array_equal(ours.order, twin.order) and np.array_equal(ours.starts, twin.starts)
    assert np.array_equal(means, expected) and ours.sizes.sum() == len(points) > 0
    assert np.abs(corners - others).max() <= 1e-14 * (float(np.abs(points - points[0]).max()) + 1e-12)
    assert abs(len(turned.starts) - len(other.starts)) <= 0.02 * len(points)  # on an edge rounding decides


@pytest.mark.parametrize("size", [1, 2, 3, 8, 40])
def test_planes_are_those_of_eigenvectors(both, size):
    scales = RNG.choice([0.0, 1e-4, 1.0], (30, 1, 1, 3))
    patches = (RNG.normal(size=(30, 200, size, 3)) * scales).reshape(-1, size, 3)
    (middles, normals, squares), (others, axes, expected) = both(patch_planes, patches)
    largest = expected[:, 2:] + 1e-300
    assert np.abs(middles - others).max() < 1e-15 * (size + 1)
    assert (np.abs(squares - expected) <= 1e-14 * size * largest).all()
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0, atol=1e-14)
    told = expected[:, 1] - expected[:, 0] > 1e-3 * largest[:, 0]  # one direction is the least
    assert size < 3 or told.sum() > 100
    assert (np.abs(np.einsum("pk,pk->p", normals, axes))[told] > 1 - 1e-10).all()


@pytest.mark.parametrize("count", [0, 1, 900])
def test_normal_sums_are_those_of_a_sparse_product(both, count):
    matrix = random_array((12, count), density=0.2, format="csc", random_state=0)
    ours, twin = both(normal_sums, matrix, 12, RNG.normal(size=count))
    assert ours == pytest.approx(twin, abs=1e-12)


@pytest.mark.parametrize("name", ["one", "coincident", "on a line", "in a plane"])
def test_what_is_flat_has_no_sphere(both, name):
    assert both(sphere_nearest, CLOUDS[name], 2.5) == [None, None]


@pytest.mark.parametrize("name", [name for name in CLOUDS if name != "in two axes"])
@pytest.mark.parametrize("highest", [True, False])
def test_heights_over_a_plan_are_the_same(both, name, highest):
    points, size, first = CLOUDS[name], np.array([9, 14]), np.array([-2, 1])
    ours, twin = both(heights_over, points, points[:, :2].min(axis=0) - 0.01, 0.21, size, highest, first)
    assert ours.shape == (9, 14) and np.array_equal(ours, twin)


@pytest.mark.parametrize("name", ["one", "few", "a leaf and one", "in a plane", "on a ball"])
@pytest.mark.parametrize("other", ["few", "in a plane", "on a ball"])
@pytest.mark.parametrize("most", [5, 128])
def test_the_closest_places_are_as_far(both, name, other, most):
    a, b = CLOUDS[name], CLOUDS[other] + RNG.normal(scale=0.5, size=3)
    samples = [(points, RNG.random(len(points))) for points in (a, b)]
    found = both(closest_places, *samples, most, 8)
    for (away, nearest), (expected, others), points in zip(*found, (a, b), strict=True):
        assert len(away) == min(most, len(points)) and (away <= nearest).all()
        assert np.allclose(nearest, others, rtol=1e-12, atol=1e-12)
        assert np.allclose(away, expected, rtol=1e-6, atol=1e-7)


SHELL = CLOUDS["on a ball"] * RNG.normal([1.0, 1.0, 0.6], 0.01, BALL.shape)
SHELL = SHELL[SHELL[:, 2] < 0.1]
HOLLOW = {
    "shell": SHELL[:1200],
    "thick shell": np.concatenate([SHELL[:900], 0.9 * SHELL[900:1500]]),
    "shell far away": 1e-2 * SHELL[:900] + 1e3,
    "two shells": np.concatenate([SHELL[:300], SHELL[300:600] + 2.0]),
}


@pytest.mark.parametrize("eyes", [None, np.empty((0, 3)), np.array([[0.0, 0.5, 9.0], [0.0, 9.0, 3.0]])])
@pytest.mark.parametrize("name", [*HOLLOW, *(name for name in CLOUDS if name != "in two axes")])
def test_clouds_are_cut_into_the_same_parts(both, name, eyes):
    points = {**HOLLOW, **CLOUDS}[name]
    found = both(lambda: [Hull.of(part) for part in convex_parts(points, 0.03 * float(np.ptp(points)), eyes)])
    least = 2 if name in HOLLOW and eyes is not None and not len(eyes) else 0
    assert len(found[0]) == len(found[1]) > least
    for one, other in zip(*found, strict=True):
        assert one.dimension == other.dimension
        assert one.volume == pytest.approx(other.volume, rel=1e-6)


@pytest.mark.parametrize("share", [0.3, 0.75, 1.0])
def test_the_same_walls_stand_around_and_above(both, share):
    turn = RNG.random(2000) * share * 2 * np.pi
    rim = np.stack([np.cos(turn), np.sin(turn), RNG.random(2000)], axis=1)
    places = RNG.uniform(-1.2, 1.2, (300, 3))
    around, expected = both(wall_around, places, rim, 0.1, 0.04, 24, 18)
    above, over = both(wall_above, places, rim, 0.1, 0.05)
    assert not np.any(both(wall_around, places, rim[:0], 0.1, 0.04, 24, 18))
    assert list(map(len, both(wall_above, places[:0], rim, 0.1, 0.05))) == [0, 0]
    assert np.array_equal(around, expected) and np.array_equal(above, over)
    assert above.any() and not above.all() and around.any() == (share > 0.5)


@pytest.mark.parametrize("name", CLOUDS)
def test_outlines_have_the_same_corners(both, name):
    flat = CLOUDS[name][:, :2]
    ours, twin = both(outline_corners, flat)
    assert {tuple(place) for place in flat[ours]} == {tuple(place) for place in flat[twin]}
    assert (len(ours) == 0) == (name in ("one", "coincident", "on a line"))
    if len(ours):  # to the left, from whichever corner
        sides = np.roll(flat[ours], -1, axis=0) - flat[ours]
        after = np.roll(sides, -1, axis=0)
        assert (sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0] > 0).all()


def test_the_same_surfaces_are_continued_to_borders(both):
    rows, columns = np.mgrid[:60, :80]
    label = 1 + (columns > 40 + 3 * np.sin(rows / 5)).astype(np.int64) + (rows > 45)
    depth = 0.8 + 0.05 * label + 1e-3 * columns + RNG.normal(size=label.shape) * 1e-3
    depth[RNG.random(label.shape) < 0.05] = 0.0
    picture = Picture.of(depth, np.roll(label, 2, axis=1))
    rim = np.flatnonzero((picture.inverse > 0) & (picture.surface < 0))
    inside = np.flatnonzero(picture.surface > 0)
    planes, expected = both(planes_around, picture, inside)
    assert np.allclose(planes, expected, rtol=0, atol=1e-10)
    for owned, least in ((True, 0.1), (False, 0.0)):
        ours, twin = both(continue_surfaces, picture, rim, owned)
        assert all(np.array_equal(a, b) for a, b in zip(ours, twin, strict=True))
        assert least < np.mean(ours[1] > 0) and (not owned or np.mean(ours[1] > 0) < 1.0)


def test_the_same_triangles_are_seen(both):
    near = RNG.normal(size=(60, 3, 3)) * [0.4, 0.3, 0.3] + [0.0, 0.0, 1.0]  # some behind the camera
    flat = np.concatenate([near[:1, [0, 0, 1]], near[:1, [0, 1, 1]]])
    table = np.array([[[-9.0, 0.3, -9.0], [9.0, 0.3, -9.0], [0.0, 0.3, 90.0]]])  # passes under the camera
    corners = np.concatenate([near, flat, table])
    paints = RNG.uniform(-50, 300, size=corners.shape)
    K = np.array([[70.0, 0, 39.5], [0, 75.0, 29.5], [0, 0, 1]])
    found = both(draw_triangles, corners, paints, K, (80, 60), 0.05, 5.0)
    (depth, owner, colours), (far, number, mixed) = found
    assert np.mean(owner == number) > 0.999  # rounding decides about a pixel on an edge
    same = owner == number
    assert np.allclose(depth[same], far[same], rtol=1e-9) and (depth[owner < 0] == 0.0).all()
    assert np.abs(colours[same].astype(int) - mixed[same]).max() <= 1
    assert (owner == len(corners) - 1).any() and depth.max() <= 5.0 and depth[owner >= 0].min() >= 0.05


def test_no_pixel_is_lost_between_neighbours():
    rows, columns = np.mgrid[:21, :21]
    grid = np.stack([columns - 10.0, rows - 10.0, 20.0 + RNG.normal(size=rows.shape)], axis=-1).reshape(-1, 3)
    first = (rows[:-1, :-1] * 21 + columns[:-1, :-1]).ravel()[:, None]
    corners = grid[np.concatenate([first + np.array([0, 1, 21]), first + np.array([1, 22, 21])])]
    K = np.array([[100.0, 0, 40.0], [0, 100.0, 40.0], [0, 0, 1]])
    depth, owner, _ = draw_triangles(corners, np.zeros_like(corners), K, (81, 81), 0.1, 99.0)
    assert (owner[2:-2, 2:-2] >= 0).all() and 15.0 < depth[40, 40] < 25.0


@pytest.mark.slow
def test_kernels_stay_within_their_memory(tmp_path):
    """The tests above, and those of kernels elsewhere, under address and undefined-behaviour sanitizers."""
    library = tmp_path / build.library().name
    why = build.build(("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1"), library)
    asked = [str(build.compiler()), "-print-file-name=libasan.so"]
    asan = subprocess.run(asked, capture_output=True, text=True)
    if why is not None or not Path(asan.stdout.strip()).is_absolute():
        pytest.skip(f"no sanitizers here: {why or 'no libasan'}")
    tests = Path(__file__).parents[2]
    elsewhere = (tests / "planner/grasp/test_windows.py", tests / "robots/arm/test_inverse.py")
    code = (
        "import sys, pytest\n"
        "from topple.topology.kernels import compiled\n"
        f"compiled.library = lambda: __import__('pathlib').Path({str(library)!r})\n"
        f"sys.exit(pytest.main({[__file__, *map(str, elsewhere)]!r} + "
        "['-qm', 'not slow', '-pno:cacheprovider', '-Wignore']))"
    )
    settings = {"LD_PRELOAD": asan.stdout.strip(), "ASAN_OPTIONS": "detect_leaks=0", "PATH": "/usr/bin:/bin"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=settings)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert "passed" in done.stdout
