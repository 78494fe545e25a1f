"""Which way is up: what contradicts equilibrium is refused, what stands or hangs as it should is not."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from topple.planner.planning.order import order
from topple.topology import InvalidInput, Scene, load_scene
from topple.topology.base.arrays import FloatArray
from topple.topology.io.assemble import Parts, assemble
from topple.topology.statics.gravity import check_up
from topple.topology.views.image import DepthImage

SHARED = Path(__file__).resolve().parents[3].parent / "shared"
AXES = {"x": (1, 0, 0), "-x": (-1, 0, 0), "y": (0, 1, 0), "-y": (0, -1, 0)}


def _box(size: tuple[float, float, float], centre: tuple[float, float, float]) -> FloatArray:
    """A closed surface of points 5 mm apart."""
    half = np.array(size) / 2
    sides: list[FloatArray] = []
    for axis in range(3):
        u, v = (k for k in range(3) if k != axis)
        grid = np.meshgrid(
            *(np.linspace(-half[k], half[k], max(2, int(2 * half[k] / 0.005))) for k in (u, v))
        )
        for side in (-half[axis], half[axis]):
            face = np.full((grid[0].size, 3), side)
            face[:, u], face[:, v] = grid[0].ravel(), grid[1].ravel()
            sides.append(face)
    return np.concatenate(sides) + np.array(centre)


def _flat(half: float = 0.4, height: float = 0.0) -> FloatArray:
    line = np.arange(-half, half, 0.006)
    plan = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    return np.column_stack([plan, np.full(len(plan), height)])


BOXES = {
    "low": _box((0.12, 0.12, 0.06), (0, 0, 0.03)),
    "high": _box((0.06, 0.06, 0.05), (0.01, 0, 0.085)),
    "beside": _box((0.08, 0.05, 0.1), (0.2, 0.05, 0.05)),
}
ON_TABLE = {"table": _flat(), **BOXES}
LEGS = [_box((0.04, 0.04, 0.7), (x, y, -0.38)) for x in (-0.35, 0.35) for y in (-0.35, 0.35)]
DESK = np.concatenate([_box((0.8, 0.8, 0.03), (0, 0, -0.015)), *LEGS])
SHELF = np.concatenate([_box((0.8, 0.3, 0.02), (0, 0, z - 0.01)) for z in (-0.4, 0.0, 0.4)])
BOWL = np.concatenate([_box((0.2, 0.005, 0.08), (0, y, 0.04)) for y in (-0.1, 0.1)] + [_flat(0.1)])


def _standing() -> dict[str, Scene]:
    """Scenes that are as they should be, with up along z."""
    up = (0, 0, 1)
    hook = _box((0.01, 0.2, 0.01), (0, 0, 0.6))
    tall = [_box((0.06, 0.01, 0.01), (0, 0, 0.61)), _box((0.06, 0.01, 0.5), (0.0, 0, 0.32))]
    return {
        "table": Scene(ON_TABLE, fixed=["table"], up=up),
        "camera": Scene(ON_TABLE, fixed=["table"], up=up, viewpoints=[[0.8, -0.8, 0.8]]),
        "camera below the board": Scene({"shelf": SHELF, **BOXES}, ["shelf"], up, [[0.2, -1.2, -0.2]]),
        "desk with legs": Scene({"table": DESK, **BOXES}, fixed=["table"], up=up),
        "box under the table": Scene(
            {**ON_TABLE, "under": _box((0.2, 0.2, 0.3), (0, 0, -0.5)), "floor": _flat(0.5, -0.65)},
            fixed=["table", "floor"],
            up=up,
        ),
        "shelf": Scene({"shelf": SHELF, **BOXES}, fixed=["shelf"], up=up),
        "in a tray": Scene({"tray": BOWL, **BOXES}, fixed=["tray"], up=up),
        "on a hook": Scene(
            {"hook": hook, "tall": np.concatenate(tall), **BOXES, "table": _flat()}, ["hook", "table"], up
        ),
        "nothing fixed": Scene({**BOXES, "tall": _box((0.06, 0.06, 0.2), (-0.2, 0, 0.1))}, up=up),
    }


@pytest.mark.parametrize("name", list(_standing()))
def test_what_stands_is_not_doubted(name):
    check_up(_standing()[name])


def _ring(radius: float, thick: float, top: float, along_x: bool = True) -> FloatArray:
    """An upright ring around the origin of the plan, whose hole ends `top` high."""
    round_, turn = np.random.default_rng(3).uniform(0, 2 * np.pi, (2, 4000))
    wide, thin = radius + thick * np.cos(turn), thick * np.sin(turn)
    flat, tall = wide * np.cos(round_), wide * np.sin(round_) + top - radius + thick
    return np.column_stack([flat, thin, tall] if along_x else [thin, flat, tall])


def _bar(thick: float) -> FloatArray:
    """A round bar along y whose top is 0.3 m high, on a post."""
    along, turn = np.random.default_rng(5).uniform((-0.06, 0.0), (0.06, 2 * np.pi), (4000, 2)).T
    bar = np.column_stack([thick * np.cos(turn), along, 0.3 - thick + thick * np.sin(turn)])
    return np.concatenate([bar, _box((0.02, 0.02, 0.34), (0, 0.07, 0.17))])


def _towel(thick: float) -> FloatArray:
    """A cloth of 2 mm that hangs down 12 cm on either side of such a bar."""
    along, across, side = (
        np.random.default_rng(7).uniform((-0.05, -0.14, 0.0), (0.05, 0.14, 2.0), (9000, 3)).T
    )
    wide = thick + 0.002 * (side > 1.0)
    turn = np.clip(across / thick, -np.pi / 2, np.pi / 2)
    fall = np.maximum(np.abs(across) - thick * np.pi / 2, 0.0)
    return np.column_stack([wide * np.sin(turn), along, 0.3 - thick + wide * np.cos(turn) - fall])


HUNG = {
    "ring": (0.01, {"ring": _ring(0.04, 0.005, 0.3)}),
    "thin ring": (0.004, {"ring": _ring(0.04, 0.003, 0.3)}),
    "mug": (
        0.014,
        {"mug": np.concatenate([_ring(0.022, 0.004, 0.3), _box((0.09, 0.07, 0.07), (0, 0, 0.225))])},
    ),
    "bag": (
        0.006,
        {"bag": np.concatenate([_ring(0.05, 0.004, 0.3), _box((0.14, 0.08, 0.15), (0, 0, 0.125))])},
    ),
    "towel": (0.01, {"towel": _towel(0.01)}),
    "rings": (0.01, {"ring": _ring(0.04, 0.005, 0.3), "linked": _ring(0.04, 0.005, 0.23, False)}),
}


@pytest.mark.parametrize("what", list(HUNG))
def test_what_hangs_on_a_bar_is_carried_by_it(what):
    thick, hung = HUNG[what]
    found = order(Scene({"table": _flat(), "bar": _bar(thick), **hung}, ["table", "bar"], (0, 0, 1)))
    assert set(found.order) == set(hung)
    assert "bar" in {support.supporter for support in found.supports}


@pytest.mark.parametrize("name", ["table", "camera", "desk with legs", "nothing fixed"])
def test_gravity_upside_down_is_refused_with_the_direction_that_fits(name):
    scene = _standing()[name].with_up((0, 0, -1))
    with pytest.raises(InvalidInput, match=r"up is 0 0 -1.*give up=\[0, 0, 1\]"):
        order(scene)


@pytest.mark.parametrize("axis", list(AXES))
def test_gravity_along_the_table_is_refused(axis):
    with pytest.raises(InvalidInput, match=r"up=\[0, 0, 1\]"):
        order(Scene(ON_TABLE, fixed=["table"], up=AXES[axis]))


def test_a_negated_table_plane_is_refused():
    scene = assemble(Parts(clouds=dict(BOXES), table_plane=[0, 0, -1, 0]), [], None)
    with pytest.raises(InvalidInput, match=r"turn round the up or table_plane"):
        order(scene)


def test_in_a_depth_image_the_cure_is_the_table(tmp_path):
    image = _image()
    with pytest.raises(InvalidInput, match=r"leave out the up that is given"):
        order(Scene.from_images([image], up=(0, 0, 1), table="auto"))


def _looking(axes: tuple[float, float, float]) -> Scene:
    """What a camera at a height of one metre sees, its pose's axes as given, where up is z."""
    pose = np.diag([*axes, 1.0])
    pose[2, 3] = 1.0
    return Scene.from_images([replace(_image(), pose_camera_to_world=pose)], up=(0, 0, 1), table="auto")


def test_a_pose_in_opengl_axes_is_told_and_the_cure_cures():
    with pytest.raises(InvalidInput, match=r"OpenGL axes.* give pose @ diag\(1, -1, -1, 1\)"):
        order(_looking((1.0, 1.0, 1.0)))
    assert len(order(_looking((1.0, -1.0, -1.0))).order) == 2


def _image() -> DepthImage:
    """A camera straight above a table that has no label, with two boxes of 10 cm on it."""
    depth, label = np.ones((240, 320)), np.zeros((240, 320), dtype=np.int64)
    for number, (row, column) in enumerate(((80, 80), (120, 200)), start=1):
        depth[row : row + 40, column : column + 40] = 0.9
        label[row : row + 40, column : column + 40] = number
    return DepthImage(depth, np.array([[300.0, 0, 160], [0, 300.0, 120], [0, 0, 1]]), label)


def test_the_table_is_found_in_what_has_no_label():
    scene = Scene.from_images([_image()], table="auto")
    assert scene.fixed == {"table"}
    assert np.allclose(np.asarray(scene.up), [0, 0, -1], atol=1e-3)
    assert len(scene.clouds["table"]) == 240 * 320 - 2 * 1600
    assert any("no label" in note for note in scene.assumptions)


def test_a_wall_and_a_floor_far_below_are_no_table():
    image = _image()
    depth = np.array(image.depth)
    depth[:, 280:] = 1.8  # the floor beside the table
    depth[:40] = np.linspace(0.5, 1.0, 40)[:, None]  # something that rises from its far edge
    scene = Scene.from_images([DepthImage(depth, image.K, image.label)], table="auto")
    assert np.allclose(np.asarray(scene.up), [0, 0, -1], atol=1e-2)
    assert np.abs(scene.clouds["table"][:, 2] - 1.0).max() < 0.021


def test_without_background_there_is_no_table():
    image = _image()
    depth = np.where(image.label > 0, image.depth, 0.0)
    assert Scene.from_images([DepthImage(depth, image.K, image.label)], table="auto").up is None


ANNOTATED = sorted((SHARED / "data" / "rgbd").glob("osd*.gt.json"))


@pytest.mark.slow
@pytest.mark.skipif(not ANNOTATED, reason="the real frames are not at ../shared/data/rgbd")
def test_real_frames_without_a_table_label_keep_what_is_annotated(tmp_path):
    for truth in ANNOTATED:
        path = truth.with_name(truth.name.replace(".gt.json", ".npz"))
        with np.load(path) as frame:
            label = np.where(frame["label"] == 1, 0, frame["label"])
            np.savez(tmp_path / "frame.npz", depth=frame["depth"], K=frame["K"], label=label)
        found = order(load_scene(tmp_path / "frame.npz")).order
        known = json.loads(truth.read_text())
        assert set(found) == set(known["objects"]) - {"1"}
        for first, then in known["removal_constraints"]:
            assert found.index(str(first)) < found.index(str(then)), (path.name, first, then)


@pytest.mark.parametrize(("factor", "unit"), [(1000.0, "millimetres"), (100.0, "centimetres")])
@pytest.mark.parametrize("fixed", [True, False])
def test_poses_in_another_unit_than_the_clouds_are_refused(factor, unit, fixed):
    places = {name: cloud.mean(axis=0) for name, cloud in BOXES.items()}
    thrown = {name: BOXES[name] - at + factor * at for name, at in places.items()}
    scene = Scene({"table": _flat(), **thrown} if fixed else thrown, ["table"] if fixed else [], (0, 0, 1))
    with pytest.raises(InvalidInput, match=f"from all others and carried by nothing, .* poses in {unit}"):
        check_up(scene)


def test_some_that_float_or_all_that_float_near_each_other_are_answered():
    up = (0, 0, 1)
    lamp = {"lamp": BOXES["high"] + np.array([0, 0, 3.0])}
    check_up(Scene({**ON_TABLE, **lamp}, ["table"], up))
    check_up(
        Scene(
            {"table": _flat(), **{name: cloud + np.array([0, 0, 0.5]) for name, cloud in BOXES.items()}},
            ["table"],
            up,
        )
    )


PILES = sorted((SHARED / "piles").glob("*.npz"))


@pytest.mark.slow
@pytest.mark.skipif(not PILES, reason="the piles are not at ../shared/piles")
def test_real_piles_stand_and_hang_upside_down():
    from topple.benchmarks.recorded import recorded_piles

    looked_at = 0
    for pile in recorded_piles(SHARED / "piles")[::5]:
        for scene in pile.scenes.values():
            check_up(scene)
            looked_at += 1
            with pytest.raises(InvalidInput, match=r"up=\[0, 0, 1\]"):
                check_up(scene.with_up((0, 0, -1)))
    assert looked_at > 0
