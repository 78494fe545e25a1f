"""Shapes are closed, stand on z = 0 and weigh what such things weigh."""

import numpy as np
import pytest
import trimesh

from topple.robots import shapes
from topple.robots.world.bodies import Body

MASSES = {  # [kg] what kitchen scales say, from small to large
    "apple": (0.13, 0.25), "ball": (0.05, 0.06), "banana": (0.09, 0.18), "bar": (0.04, 0.15),
    "block": (0.05, 0.12), "bottle": (0.4, 0.65),
    "bowl": (0.2, 0.5), "box": (0.1, 0.6), "can": (0.3, 0.45),
    "cup": (0.12, 0.35), "fork": (0.03, 0.07), "knife": (0.05, 0.12), "lemon": (0.07, 0.15),
    "mug": (0.2, 0.4), "orange": (0.13, 0.25), "pear": (0.12, 0.22), "plate": (0.35, 0.8),
    "plum": (0.04, 0.1), "spoon": (0.03, 0.08), "strawberry": (0.01, 0.04),
    "tin": (0.3, 0.42), "tray": (0.2, 0.8),
}  # fmt: skip


@pytest.fixture(params=shapes.__all__)
def body(request: pytest.FixtureRequest) -> Body:
    return getattr(shapes, request.param)()


def solid(body: Body) -> trimesh.Trimesh:
    return trimesh.Trimesh(body.mesh.vertices, body.mesh.faces, process=False)


def depths(body: Body, points: np.ndarray) -> np.ndarray:
    """Distance of points behind the nearest face plane of the part they are deepest in; negative outside."""
    hulls = [trimesh.convex.convex_hull(part) for part in body.parts]
    outside = [
        (points @ hull.face_normals.T - np.einsum("ij,ij->i", hull.face_normals, hull.triangles[:, 0])).max(1)
        for hull in hulls
    ]
    return -np.min(outside, axis=0)


def test_mesh_is_watertight_and_faces_outwards(body):
    mesh = solid(body)
    assert mesh.is_watertight and mesh.is_winding_consistent
    assert mesh.volume > 0


def test_stands_on_the_ground_in_the_middle(body):
    assert body.lower[2] == pytest.approx(0, abs=1e-9)
    if body.kind != "mug":  # its handle stands out
        np.testing.assert_allclose((body.lower + body.upper)[:2] / 2, 0, atol=6e-4)


def test_weighs_what_such_a_thing_weighs(body):
    low, high = MASSES[body.kind]
    assert low <= body.mass <= high


def test_parts_cover_the_mesh_and_nothing_else(body):
    surface = body.surface(600, np.random.default_rng(0))
    assert depths(body, surface).min() > -2e-4  # no point of the surface outside the parts
    if body.kind != "plate":  # whose parts fill the hollow in the foot ring
        assert np.quantile(depths(body, surface), 0.9) < 6e-4  # and none deep inside: hollows are hollow


def test_mass_lies_where_the_volume_is(body):
    mesh = solid(body)
    np.testing.assert_allclose(body.centre_of_mass, mesh.center_mass, atol=1e-6)
    np.testing.assert_allclose(
        body.inertia, mesh.moment_inertia * body.mass / mesh.volume, rtol=1e-6, atol=1e-14
    )


def test_plate_bowl_cup_and_tray_are_hollow():
    for body in (shapes.plate(), shapes.bowl(), shapes.cup(), shapes.mug(), shapes.tray()):
        above_floor = np.array([[0.0, 0.0, body.upper[2] - 0.002]])
        assert depths(body, above_floor)[0] < 0


def test_dimensions_are_what_was_asked_for():
    can = shapes.can(diameter=0.085, height=0.034)
    np.testing.assert_allclose(can.upper - can.lower, [0.085, 0.085, 0.034], atol=1e-9)
    plate = shapes.plate(diameter=0.27, height=0.025)
    np.testing.assert_allclose(plate.upper - plate.lower, [0.27, 0.27, 0.025], atol=1e-9)
    tray = shapes.tray(size=(0.4, 0.3, 0.05))
    np.testing.assert_allclose(tray.upper - tray.lower, [0.4, 0.3, 0.05], atol=1e-9)
