"""Tables as users have them: thick boards, a PyBullet box, a stock URDF, a shelf, a plane without a cloud."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pybullet
import pybullet_data
import pytest
import trimesh
from moving import at

from topple.planner import NoSafePlan, order, plan, run
from topple.robots import scene_from_world
from topple.robots.catalog import robot
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.solids import hidden_depth, solids_of
from topple.topology.io.load import load_scene
from topple.topology.scene.scene import Scene

UP = np.array([0.0, 0.0, 1.0])
TAKEN = [("top", "remove"), ("low", "free")]


def box(size: tuple[float, float, float], x: float, y: float, z: float) -> trimesh.Trimesh:
    """A box that stands on height z, or hangs below it where its height is negative."""
    made = trimesh.creation.box(np.abs(size))
    made.apply_translation([x, y, z + size[2] / 2])
    return made


def stack(z: float = 0.0) -> dict[str, trimesh.Trimesh]:
    return {"low": box((0.06, 0.06, 0.06), 0, 0, z), "top": box((0.05, 0.05, 0.05), 0, 0, z + 0.06)}


def folder(path: Path, fixed: str, **meshes: trimesh.Trimesh) -> Scene:
    for name, mesh in meshes.items():
        mesh.export(path / f"{name}.stl")
    return load_scene(path, fixed=[fixed], up=UP)


def board(path: Path, thickness: float, size: tuple[float, float] = (0.9, 0.7)) -> Scene:
    return folder(path, "table", table=box((*size, -thickness), 0, 0, 0), **stack())


def desk(path: Path, lid: float = 0.35) -> Scene:
    """A desk with a board on a back wall over its rear: one can on that, one below it."""
    parts = [box((1.0, 0.8, -0.02), 0, 0.05, 0), box((1.0, 0.25, -0.02), 0, 0.325, lid)]
    shelf = trimesh.util.concatenate([*parts, box((1.0, 0.02, lid), 0, 0.46, 0)])
    cans = {"above": box((0.05, 0.05, 0.06), 0, 0.25, lid), "below": box((0.05, 0.05, 0.06), 0, 0.25, 0)}
    return folder(path, "shelf", shelf=shelf, **cans, **stack())


@pytest.fixture
def client() -> Iterator[int]:
    number: int = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(number)


def put(client: int, half: float, z: float, mass: float) -> int:
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[half] * 3, physicsClientId=client)
    return pybullet.createMultiBody(mass, shape, basePosition=[0, 0, z + half], physicsClientId=client)


@pytest.mark.parametrize("thickness", [pytest.param(0.02, marks=pytest.mark.slow), 0.04])
def test_a_board_as_a_mesh_is_a_table(tmp_path, thickness):
    found = plan(board(tmp_path, thickness), ["low"], "panda")
    assert [(step.object, step.action) for step in found.steps] == TAKEN


@pytest.mark.slow
def test_a_pybullet_box_is_a_table(client):
    size = [0.45, 0.35, 0.02]
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=size, physicsClientId=client)
    table = pybullet.createMultiBody(0, shape, basePosition=[0, 0, -0.02], physicsClientId=client)
    names = {table: "table", put(client, 0.03, 0.0, 0.2): "low", put(client, 0.025, 0.06, 0.2): "top"}
    found = plan(scene_from_world(client, names=names), ["low"], "panda")
    assert [(step.object, step.action) for step in found.steps] == TAKEN


@pytest.mark.slow
def test_the_stock_table_with_its_legs_is_a_table(client):
    path = str(Path(pybullet_data.getDataPath()) / "table" / "table.urdf")
    table = pybullet.loadURDF(path, useFixedBase=True, physicsClientId=client)
    top = pybullet.rayTest([0, 0, 2], [0, 0, 0], physicsClientId=client)[0][3][2]
    names = {table: "table", put(client, 0.03, top, 0.2): "low", put(client, 0.025, top + 0.06, 0.2): "top"}
    scene = scene_from_world(client, names=names)
    found = plan(scene, ["low"], "panda")
    assert [(step.object, step.action) for step in found.steps] == TAKEN
    assert found.pose_base_to_world[2][3] == pytest.approx(top, abs=0.005)


@pytest.mark.slow
def test_a_plane_without_a_cloud_reaches_as_far_as_the_arm(tmp_path):
    clouds = {name: mesh.sample(3000, seed=0) for name, mesh in stack().items()}
    np.savez(tmp_path / "scene.npz", table_plane=[0.0, 0.0, 1.0, 0.0], **clouds)
    scene = load_scene(tmp_path / "scene.npz")
    assert np.ptp(scene.clouds["table"], axis=0)[:2].min() > 2.0
    assert len(scene.clouds["table"]) < 20_000
    assert any("since a plane has no edge" in note for note in scene.assumptions)
    found = plan(scene, ["low"], "panda")
    assert [(step.object, step.action) for step in found.steps] == TAKEN


def test_on_a_shelf_each_board_carries_what_stands_on_it(tmp_path):
    scene = desk(tmp_path)
    seen = {name: cloud[cloud[:, 2] > cloud[:, 2].max() - 0.01] for name, cloud in scene.clouds.items()}
    lids = Scene({**seen, "shelf": scene.clouds["shelf"]}, fixed=["shelf"], up=UP)
    for name, depth in {"above": 0.05, "below": 0.05, "low": 0.05, "top": 0.04}.items():
        assert hidden_depth(name, lids, UP) == pytest.approx(depth, abs=0.008), name
    parts = solids_of(scene)["shelf"]
    free = np.array([0.0, 0.25, 0.15])  # between the boards
    assert not any(((part.min(axis=0) < free) & (part.max(axis=0) > free)).all() for part in parts)


def test_a_board_shields_what_stands_on_it(tmp_path):
    found = order(desk(tmp_path, lid=0.22), verify=True)
    before = {("top", "low"), ("low", "below")}  # what stands in the way out from under the board
    assert {(edge.first, edge.then) for edge in found.graph.dependencies} == before
    assert {support.supporter for support in found.supports if support.supported == "above"} == {"shelf"}


@pytest.mark.slow
@pytest.mark.parametrize(("target", "steps"), [("low", TAKEN), ("above", [("above", "free")])])
def test_objects_on_both_boards_of_a_shelf_are_planned(tmp_path, target, steps):
    found = plan(desk(tmp_path), [target], "panda")
    assert [(step.object, step.action) for step in found.steps] == steps


@pytest.mark.slow
def test_a_thick_table_is_acted_on(tmp_path):
    record = run(board(tmp_path, 0.04), ["low"], "panda-suction")
    assert record.success, record.violations
    assert [(step.object, step.action) for step in record.steps] == TAKEN


def certificate(scene: Scene, base: np.ndarray | None = None) -> str:
    with pytest.raises(NoSafePlan) as caught:
        plan(scene, ["low"], robot("panda"), pose_base_to_world=base)
    return " ".join(caught.value.certificate)


def test_a_base_too_far_from_any_free_place_is_said_with_one_that_would_do(tmp_path):
    base = at(-1.6, 0.0, 0.0)
    said = certificate(board(tmp_path, 0.02), base)
    assert "no free place for top within reach: the nearest is 1." in said
    x, y = (float(word) for word in said.split("--base ")[1].split()[:2])
    assert 0.3 < np.hypot(x, y) < 0.7


def test_a_table_too_small_is_said_with_its_size(tmp_path):
    said = certificate(board(tmp_path, 0.02, (0.12, 0.1)), np.array(BESIDE))
    assert "no level surface is large enough for top" in said
    assert "of table, is 0.12 x 0.10 m" in said


BESIDE = [[1.0, 0, 0, -0.45], [0, 1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]]


def test_a_table_full_of_other_things_is_said_with_their_names(tmp_path):
    crates = {
        f"crate_{x}{y}": box((0.1, 0.1, 0.03), 0.14 * x, 0.14 * y, 0)
        for x in (-1, 0, 1) for y in (-1, 0, 1) if (x, y) != (0, 0)
    }  # fmt: skip
    table = box((0.44, 0.44, -0.02), 0, 0, 0)
    said = certificate(folder(tmp_path, "table", table=table, **stack(), **crates), np.array(BESIDE))
    assert "every place that is large enough for top is taken" in said
    assert "crate_11" in said


def test_what_has_no_level_surface_is_no_table(tmp_path):
    wall = box((0.8, 0.02, 0.8), 0, 0.2, 0)
    with pytest.raises(InvalidInput, match="fixed 'wall': no level surface is seen"):
        run(folder(tmp_path, "wall", wall=wall, **stack()), ["low"], "panda")
