"""Every shortcut of both rules, held against the rule written down without any, on 1,000 random scenes."""

from itertools import combinations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.topology.base.tolerances import TOLERANCES
from topple.topology.geometry.hull import Hull
from topple.topology.relations.cavity import is_roofed, is_surrounded
from topple.topology.relations.relate import relate
from topple.topology.relations.surface import SurfaceCloud
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation, classify

DEVIATION = 0.002
KINDS = ("ball", "ball", "box", "box", "box", "can", "can", "bowl", "bowl", "sheet", "rod", "place")


def random_shape(rng, count, kinds=KINDS):
    """A noisy ball, box, can, bowl, sheet, rod or single place around the origin, turned somehow."""
    kind = rng.choice(kinds)
    points = rng.uniform(-1, 1, (count, 3))
    size = rng.uniform(0.015, 0.05, 3)
    if kind == "ball" or kind == "bowl":
        points = rng.normal(size=(count, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        if kind == "bowl":
            points[:, 2] = -np.abs(points[:, 2])
            return points * [0.06, 0.06, 0.05] + rng.normal(0, 0.0003, (count, 3))
    elif kind == "box":
        axis = rng.integers(0, 3, count)
        points[np.arange(count), axis] = np.sign(points[np.arange(count), axis])
    elif kind == "can":
        points[:, :2] /= np.linalg.norm(points[:, :2], axis=1, keepdims=True)
    elif kind == "sheet":
        points[:, 2] = 0
    elif kind == "rod":
        points[:, 1:] = 0
    else:
        points *= 0
    turn = (
        Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()
        if rng.random() < 0.5
        else np.eye(3)
    )
    return points * size @ turn.T + rng.choice([0.0, 0.0005]) * rng.normal(size=(count, 3))


def random_scene(rng, points, most):
    """Two things or more, apart, side by side, on top of each other or in each other."""
    count = rng.integers(points // 8, points, most)
    clouds = {"thing 0": random_shape(rng, count[0], KINDS[:-1])}
    for number in range(1, rng.integers(2, most + 1)):
        cloud = random_shape(rng, count[number])
        other = clouds[f"thing {rng.integers(number)}"]
        place = rng.choice(["inside", "on", "beside", "anywhere"])
        if place == "inside":
            cloud = cloud * rng.uniform(0.2, 0.9) + other.mean(axis=0)
        elif place == "anywhere":
            cloud = cloud + rng.uniform(-0.12, 0.12, 3)
        else:
            axis = 2 if place == "on" else int(rng.integers(2))
            step = other[:, axis].max() - cloud[:, axis].min() + rng.uniform(-0.006, 0.006)
            cloud = cloud + other.mean(axis=0) * (np.arange(3) != axis) + step * np.eye(3)[axis]
        clouds[f"thing {number}"] = cloud
    return Scene(clouds)


def slow_counts(points, hull):
    """Interior, boundary and exterior of a cloud: every point against every facet."""
    distance = (points @ hull.normals.T + hull.offsets).max(axis=1)
    distance[((points < hull.lower - DEVIATION) | (points > hull.upper + DEVIATION)).any(axis=1)] = np.inf
    inner, outer = int((distance < -DEVIATION).sum()), int((distance > DEVIATION).sum())
    return [inner, len(points) - inner - outer, outer]


def slow_plain_matrix(a, b):
    """R(A, B) by the paper's definitions."""
    return [slow_counts(a, Hull.of(b)), slow_counts(b, Hull.of(a))]


def slow_interior(a, b):
    """Which points of A lie deep in B's hull, with B higher around them and not just above them."""
    hull = Hull.of(b)
    if hull.dimension < 3:
        return np.zeros(len(a), dtype=bool)
    centred = b - b.mean(axis=0)
    axes = np.linalg.eigh(centred.T @ centred)[1].T
    apart = np.sort(np.linalg.norm(b[:, None] - b[None], axis=2), axis=1)
    spacing = float(np.median(apart[:, 4])) if len(b) >= 5 else 0.0
    deep = (a @ hull.normals.T + hull.offsets).max(axis=1) < -DEVIATION
    held = np.zeros(len(a), dtype=bool)
    for up in (*axes, *-axes):
        above, below = (is_roofed(a[deep], b, way, DEVIATION, spacing) for way in (up, -up))
        held[deep] |= is_surrounded(a[deep], b, up, DEVIATION) & ~(above & ~below)
    return held


def slow_surface_distance(points, surface):
    """Distances to the plane patches through the eight nearest samples of a surface, as far as they reach."""
    table = np.linalg.norm(points[:, None] - surface[None], axis=2)
    index = np.argsort(table, axis=1, kind="stable")[:, :8]
    nearest = np.take_along_axis(table, index[:, :1], axis=1)[:, 0]
    if len(surface) < 3:
        return nearest
    patch = surface[index]
    middle = patch.mean(axis=1)
    spread = patch - middle[:, None]
    normal = np.linalg.eigh(np.swapaxes(spread, 1, 2) @ spread)[1][:, :, 0]
    height = ((points - middle) * normal).sum(axis=1)
    beside = nearest**2 - ((points - patch[:, 0]) * normal).sum(axis=1) ** 2
    reach = 0.5 * np.linalg.norm(patch[:, 1:4] - patch[:, :1], axis=2).mean(axis=1)
    return np.minimum(nearest, np.hypot(height, np.maximum(np.sqrt(np.maximum(beside, 0)) - reach, 0)))


def slow_gap(a, b):
    """The distance that few enough strays fall below, from the nearer side."""
    rank = min(8, 1 + min(len(a), len(b)) // 60)
    return min(
        np.sort(slow_surface_distance(*pair))[min(rank, len(pair[0])) - 1] for pair in ((a, b), (b, a))
    )


def slow_default_relation(a, b):
    """The default rule for complete clouds without a known upward direction, no more than 400 points each."""
    a, b = (SurfaceCloud.of("", cloud).points for cloud in (a, b))
    apart = np.maximum(np.maximum(a.min(axis=0) - b.max(axis=0), b.min(axis=0) - a.max(axis=0)), 0)
    if (apart > TOLERANCES.reach).any():
        return Relation.DISJOINT, np.array([[0, 0, len(a)], [0, 0, len(b)]])
    touching = slow_gap(a, b) <= DEVIATION
    pattern, matrix = [], []
    for one, other in ((a, b), (b, a)):
        inside = slow_interior(one, other)
        table = np.linalg.norm(one[:, None] - other[None], axis=2)
        outside = ~inside & (table.min(axis=1) > DEVIATION)
        matrix.append([inside.sum(), (~inside & ~outside).sum(), outside.sum()])
        hull = Hull.of(other)
        outside &= (one @ hull.normals.T + hull.offsets).max(axis=1) > 0
        fewest = max(1 if len(one) < 30 else 3, int(np.ceil(TOLERANCES.interior_share * len(one))))
        held = inside.sum() >= fewest
        beyond = outside.sum() > TOLERANCES.exterior_share * len(one) if held else not touching
        pattern.append([held, touching or not beyond, beyond])
    return classify(pattern), np.array(matrix)


SCENES = pytest.mark.parametrize("scenes", [60, pytest.param(1000, marks=pytest.mark.slow)])


@SCENES
def test_the_plain_rule_equals_every_point_against_every_facet(scenes):
    rng = np.random.default_rng(0)
    seen = set()
    for number in range(scenes):
        scene = random_scene(rng, 3000, 2) if number % 40 == 0 else random_scene(rng, 150, 3)
        relations = relate(scene, deviation=DEVIATION, plain=True)
        for a, b in combinations(scene.names, 2):
            matrix = slow_plain_matrix(scene.clouds[a], scene.clouds[b])
            pair = relations.between(a, b)
            assert pair.relation is classify(matrix), (number, a, b, matrix)
            assert number % 10 or pair.matrix.tolist() == matrix, (number, a, b)
            seen.add(pair.relation)
    assert seen == set(Relation) or (scenes < 1000 and len(seen) >= 4)


@SCENES
def test_the_default_rule_equals_every_point_against_every_point(scenes):
    rng = np.random.default_rng(1)
    seen = set()
    for number in range(scenes):
        scene = random_scene(rng, 100, 3)
        relations = relate(scene, deviation=DEVIATION)
        for a, b in combinations(scene.names, 2):
            expected, matrix = slow_default_relation(scene.clouds[a], scene.clouds[b])
            pair = relations.between(a, b)
            assert pair.relation is expected, (number, a, b)
            assert pair.matrix.tolist() == matrix.tolist(), (number, a, b)
            assert (pair.reason is None) == (classify(matrix) is expected), (number, a, b, pair.reason)
            seen.add(expected)
    assert seen == set(Relation) or (scenes < 1000 and len(seen) >= 4)
