import numpy as np
import pytest
import trimesh

from topple.planner.motion.certificate import Certifier
from topple.planner.motion.collision import Checker
from topple.planner.motion.obstacles import Ball, Cuboid, Cylinder, parts_of
from topple.robots.catalog import robot
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.mesh import Mesh


def placed(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def mesh_of(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(np.asarray(shape.vertices), np.asarray(shape.faces))


def states(count: int) -> np.ndarray:
    arm = robot("panda")
    return np.random.default_rng(0).uniform(arm.lower, arm.upper, (count, 7))


def test_a_box_is_the_same_as_parts_as_a_mesh_as_a_primitive_and_as_a_cloud() -> None:
    pose, size = placed(0.45, 0.1, 0.3), np.array([0.3, 0.2, 0.4])
    shape = trimesh.creation.box(size, transform=pose)
    cloud = np.concatenate([shape.vertices, trimesh.sample.sample_surface(shape, 4000, seed=1)[0]])
    q, arm = states(600), robot("panda")
    found = [
        Checker(arm, np.eye(4), {"thing": thing}).free(q)
        for thing in ([np.asarray(shape.vertices)], mesh_of(shape), Cuboid(size, pose), cloud)
    ]
    assert 0.1 < found[0].mean() < 0.9
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0], found[2])
    assert (found[0] != found[3]).mean() < 0.01  # the cloud is thinned before it is cut


@pytest.mark.parametrize(
    ("primitive", "shape"),
    [
        (Ball(np.array([0.4, 0.0, 0.3]), 0.1), trimesh.creation.icosphere(subdivisions=4, radius=0.1)),
        (
            Cylinder(0.08, 0.4, placed(0.4, 0.0, 0.3)),
            trimesh.creation.cylinder(radius=0.08, height=0.4, sections=96),
        ),
    ],
)
def test_a_primitive_lies_within_its_part_which_is_little_wider(
    primitive: Ball | Cylinder, shape: trimesh.Trimesh
) -> None:
    (part,) = parts_of("thing", primitive)
    points = np.asarray(shape.vertices) + np.array([0.4, 0.0, 0.3])
    for direction in np.random.default_rng(0).normal(size=(200, 3)):
        direction /= np.linalg.norm(direction)
        assert -1e-6 < (part @ direction).max() - (points @ direction).max() < 0.004


def test_a_hollow_mesh_stays_open() -> None:
    tube = trimesh.creation.annulus(r_min=0.16, r_max=0.18, height=0.3)
    tube.apply_translation((0.5, 0.0, 0.15))
    arm = robot("panda")
    down = np.diag([1.0, -1.0, -1.0, 1.0])
    down[:3, 3] = 0.5, 0.0, 0.2
    (q,) = (found[:1] for found in arm.inverse(down))
    assert len(q) == 1
    assert Checker(arm, np.eye(4), {"tube": mesh_of(tube)}).free(q).all()
    assert not Checker(arm, np.eye(4), {"tube": [np.asarray(tube.vertices)]}).free(q).any()


def test_what_has_no_extent_is_refused_by_name() -> None:
    for primitive in (Cuboid(np.array([0.1, 0.0, 0.1])), Ball(np.zeros(3), -1.0), Cylinder(0.1, np.nan)):
        with pytest.raises(InvalidInput, match="'thing': expected sizes above zero"):
            Checker(robot("panda"), np.eye(4), {"thing": primitive})


def test_an_edge_is_certified_or_its_witness_named() -> None:
    arm = robot("panda")
    a, b = arm.home.copy(), arm.home.copy()
    a[0], b[0] = -0.6, 0.6
    free = Certifier(Checker(arm, np.eye(4), {})).certify(a[None], b[None])[0]
    assert free.proven
    assert free.clearance > 0
    post = Cuboid(np.array([0.02, 0.02, 1.0]), placed(0.3, 0.0, 0.5))
    barred = Certifier(Checker(arm, np.eye(4), {"post": post})).certify(a[None], b[None])[0]
    assert not barred.proven
    assert barred.contact is not None
    assert barred.contact.b == "post"
