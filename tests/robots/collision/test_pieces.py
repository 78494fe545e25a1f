"""A concave surface is cut into convex pieces that hold all it encloses and little more."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from topple.robots.collision.pieces import convex_pieces


def _box(size: tuple[float, float, float], centre: tuple[float, float, float]) -> trimesh.Trimesh:
    box = trimesh.creation.box(size)
    box.apply_translation(centre)
    return box


def _fork() -> list[trimesh.Trimesh]:
    palm = _box((0.02, 0.2, 0.02), (0.0, 0.0, 0.01))
    return [palm, *(_box((0.02, 0.01, 0.2), (0.0, y, 0.12)) for y in (-0.095, 0.095))]


def _table() -> list[trimesh.Trimesh]:
    """Four legs under a board: steps along all three axes."""
    legs = [_box((0.04, 0.04, 0.4), (x, y, 0.2)) for x in (-0.28, 0.28) for y in (-0.18, 0.18)]
    return [_box((0.6, 0.4, 0.02), (0.0, 0.0, 0.41)), *legs]


def _volume(pieces: list[np.ndarray]) -> float:
    return sum(ConvexHull(piece).volume for piece in pieces)


@pytest.mark.parametrize(("solids", "most"), [(_fork(), 1.01), (_table(), 3.0)], ids=["fork", "table"])
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_pieces_hold_the_solid_and_little_more(solids, most, turn):
    pose = trimesh.transformations.euler_matrix(turn, 2 * turn, 0.5 * turn)
    turned = [solid.copy().apply_transform(pose) for solid in solids]
    pieces = convex_pieces(np.concatenate([np.asarray(solid.triangles) for solid in turned]))
    faces = [ConvexHull(piece).equations for piece in pieces]
    rng = np.random.default_rng(0)
    for solid, whole in zip(solids, turned, strict=True):
        low, high = solid.bounds
        inside = trimesh.transform_points(rng.uniform(low, high, (2000, 3)), pose)
        points = np.concatenate([inside, whole.vertices])
        beyond = np.min([(points @ f[:, :3].T + f[:, 3]).max(axis=1) for f in faces], axis=0)
        assert beyond.max() < 2e-6, "never smaller than the true shape"
    hull = ConvexHull(np.concatenate([whole.vertices for whole in turned])).volume
    true = sum(solid.volume for solid in solids)
    assert _volume(pieces) < (most * true if turn == 0.0 else hull)


def test_what_is_convex_stays_whole():
    for solid in (_box((0.1, 0.2, 0.3), (0.0, 0.0, 0.0)), trimesh.creation.icosphere(subdivisions=3)):
        assert len(convex_pieces(np.asarray(solid.triangles))) == 1
