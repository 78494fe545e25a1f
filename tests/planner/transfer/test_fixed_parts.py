"""Arms about tables whose own cloud has a wall, a post or a notch: held against the true bodies."""

import numpy as np
import pytest
from on_table import BASE

from topple.planner import plan
from topple.planner.placement.free_space import free_spaces
from topple.planner.planning.plan_format import Plan
from topple.planner.verify.replay import Replay
from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.collision.fcl_bodies import apart
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.bodies import Body
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import move_parts, solids_of
from topple.topology.bodies.tops import tops_of
from topple.topology.geometry.hull import Hull
from topple.topology.geometry.rigid import move_points
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

UP = np.array([0.0, 0.0, 1.0])
CAN = shapes.box("can", (0.05, 0.05, 0.1))
FAR_WALL = ((0.02, 0.9, 0.3), pose_at(0.11, 0.0, 0.0))
SCREEN = ((0.02, 0.3, 0.3), pose_at(-0.12, 0.0, 0.0))
CRATE = ((0.14, 0.14, 0.14), pose_at(0.0, 0.13, 0.0))
PARTS = {"wall": FAR_WALL, "screen": SCREEN, "crate": CRATE}


def sheet(low: tuple[float, float], high: tuple[float, float], spacing: float, z: float = 0.0) -> FloatArray:
    x, y = np.meshgrid(*(np.arange(a, b + spacing / 2, spacing) for a, b in zip(low, high, strict=True)))
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)])


def scene_with(
    part: str | None, spacing: float = 0.006, noise: float = 0.0, sparse: float | None = None
) -> Scene:
    """A can on a table whose one cloud has a part that rises from it."""
    rng = np.random.default_rng(0)
    table = sheet((-0.45, -0.45), (0.45, 0.45), spacing)
    if part is not None:
        body, pose = true(part)
        area = 2.0 * sum(a * b for a, b in zip(PARTS[part][0], np.roll(PARTS[part][0], 1), strict=True))
        table = np.vstack(
            [table, move_points(body.surface(round(area / (sparse or spacing) ** 2), rng), pose)]
        )
    table = table + rng.normal(0.0, noise, table.shape)
    return Scene({"table": table, "can": CAN.surface(2000, rng)}, fixed=["table"], up=UP)


def true(part: str) -> tuple[Body, FloatArray]:
    size, pose = PARTS[part]
    return shapes.box(part, size), pose


def inside(found: Plan, part: str) -> int:
    """How many states of a plan have the arm or the can in a part as it truly is."""
    arm, count = robot(found.robot), 0
    body, pose = true(part)
    solid, base = move_parts(body.parts, pose), np.array(found.pose_base_to_world)
    for piece in Replay(found, arm, 0.05).pieces:
        links = np.matmul(base, arm.forward(piece.states, piece.hand))
        tools = np.matmul(base, arm.tool_pose(piece.states, piece.segment.tool))
        for k in range(len(piece.states)):
            bodies = [move_parts(link, links[k, i]) for i, link in enumerate(arm.parts) if link]
            bodies += [move_parts(CAN.parts, tools[k] @ held) for held in piece.held.values()]
            count += sum(not apart(some, solid, 0.0) for some in bodies)
    return count


@pytest.mark.slow
@pytest.mark.parametrize(("part", "spacing"), [("wall", 0.02), ("crate", 0.006)])
def test_a_plan_keeps_clear_of_every_part_of_a_fixed_cloud(part, spacing):
    scene, bare = scene_with(part, spacing), scene_with(None, spacing)
    found = plan(scene, ["can"], "panda", pose_base_to_world=BASE)
    assert inside(found, part) == 0
    assert (checked := found.verify(scene)).ok, [(bad.name, bad.value, bad.witness) for bad in checked.failed]
    blind = plan(bare, ["can"], "panda", pose_base_to_world=BASE)
    assert blind.verify(bare).ok
    assert "points outside of the plan's bodies" in [bad.name for bad in blind.verify(scene).failed]


@pytest.mark.parametrize(
    ("spacing", "noise", "sparse"), [(0.005, 0.002, 0.005), (0.02, 0.0, 0.02), (0.004, 0.001, 0.025)]
)
@pytest.mark.parametrize("part", list(PARTS))
def test_however_dense_a_fixed_cloud_is_nothing_of_it_is_left_out(part, spacing, noise, sparse):
    scene = scene_with(part, spacing, noise, sparse)
    body, pose = true(part)
    hulls = [Hull.of(solid) for solid in solids_of(scene)["table"]]
    corners = move_points(np.vstack(body.parts), pose)
    middle = corners.mean(axis=0)
    # points of the surface, an eighth of the way in, where plates are thin and spaced points end early
    at = corners + 0.125 * (middle - corners)
    surface = move_points(body.surface(400, np.random.default_rng(1)), pose)
    surface = surface[(surface > at.min(axis=0)).any(axis=1) & (surface[:, 2] < at[:, 2].max())]
    assert len(surface) > 100
    out = np.min([hull.facet_distance(surface) for hull in hulls], axis=0)
    assert out.max() < 0.012 + sparse
    levels = {round(top.height, 2) for top in tops_of(scene.clouds["table"], UP).tops}
    assert 0.0 in levels and levels <= {0.0, 0.14}  # and no top is made up


def test_strays_above_a_table_are_no_part_of_it():
    rng = np.random.default_rng(0)
    table = sheet((-0.45, -0.45), (0.45, 0.45), 0.006)
    strays = rng.uniform((-0.4, -0.4, 0.02), (0.4, 0.4, 0.3), (100, 3))
    found = tops_of(np.vstack([table, strays]), UP)
    assert found.flat


def corner_bench(spacing: float = 0.01) -> Scene:
    """A can on a floor, in the corner of a bench like an L that is 20 cm high."""
    bench = np.vstack(
        [sheet((-0.45, 0.1), (0.45, 0.45), spacing, 0.2), sheet((-0.45, -0.45), (-0.1, 0.1), spacing, 0.2)]
    )
    floor = sheet((-0.09, -0.45), (0.45, 0.09), spacing)
    can = move_points(CAN.surface(2000, np.random.default_rng(0)), pose_at(0.05, -0.06, 0.0))
    return Scene({"bench": bench, "floor": floor, "can": can}, fixed=["bench", "floor"], up=UP)


def test_a_bench_like_an_l_does_not_fill_its_corner():
    scene = corner_bench()
    hulls = [Hull.of(solid) for solid in solids_of(scene)["bench"]]
    for place, filled in (((0.05, -0.06, 0.19), False), ((-0.3, -0.3, 0.19), True), ((0.3, 0.3, 0.19), True)):
        assert any(hull.facet_distance(np.array([place]))[0] < 0 for hull in hulls) == filled
    top = next(space for space in free_spaces(Situation(scene)) if space.owner == "bench")
    for place, free in (((0.05, -0.06), False), ((-0.3, -0.2), True)):
        cell = np.floor((np.array(place) - top.origin) / top.cell).astype(int)
        assert bool(top.distance[tuple(cell)] > 0.0) == free
    found = plan(scene, ["can"], "panda", pose_base_to_world=pose_at(0.05, -0.6, 0.0) @ turned())
    assert found.verify(scene).ok


def turned() -> FloatArray:
    pose = np.eye(4)
    pose[:2, :2] = [[0.0, -1.0], [1.0, 0.0]]
    return pose
