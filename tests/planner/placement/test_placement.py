import numpy as np
import pytest
from on_table import table

from topple.planner.placement.placement import placements
from topple.planner.placement.resting import resting_poses
from topple.planner.placement.stacking import placements_on
from topple.robots.shapes.boxes import box, can
from topple.robots.shapes.cutlery import spoon
from topple.robots.shapes.fruit import lemon
from topple.robots.shapes.tableware import bowl
from topple.robots.world.bodies import Body
from topple.topology.base.errors import UnknownObject
from topple.topology.bodies.solids import fixed_parts, hidden_depth, solids_of
from topple.topology.bodies.tops import tops_of
from topple.topology.scene.scene import Scene

UP = np.array([0.0, 0.0, 1.0])


def tilted(body: Body, angle: float, lift: float = 0.0, aside: float = 0.0) -> np.ndarray:
    points = body.surface(3000, np.random.default_rng(0))
    turn = np.array(
        [[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]]
    )
    points = points @ turn.T
    return points + np.array([aside, 0.0, lift - points[:, 2].min()])


def on_table(size: float = 0.5, **clouds: np.ndarray) -> Scene:
    return Scene({"table": table(size), **clouds}, fixed=["table"], up=UP)


def after(scene: Scene, name: str, pose: np.ndarray) -> np.ndarray:
    return scene.clouds[name] @ pose[:3, :3].T + pose[:3, 3]


def test_placed_things_stand_just_above_the_table_and_off_everything():
    scene = on_table(can=tilted(can(), 0.0), box=tilted(box(), 0.0, aside=0.15))
    found = placements("can", scene)
    assert found
    for place in found:
        cloud = after(scene, "can", place.pose_before_to_after)
        assert 0.002 < cloud[:, 2].min() < 0.006
        gaps = np.linalg.norm(cloud[:, None, :2] - scene.clouds["box"][None, ::10, :2], axis=2)
        assert gaps.min() > 0.02


def test_poses_are_rigid():
    scene = on_table(can=tilted(can(), 0.4))
    found = placements("can", scene)
    assert len(found) > 5
    for place in found:
        rotation = place.pose_before_to_after[:3, :3]
        assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_a_tilted_can_is_put_upright_when_that_is_nearer():
    cloud = tilted(can(), 0.35)
    rest = resting_poses(cloud, [cloud], UP)[0]
    assert rest.turn == pytest.approx(0.35, abs=0.06)


def test_a_spoon_tilted_over_a_rim_is_put_down_flat():
    cloud = tilted(spoon(), 0.2, lift=0.01)
    rest = resting_poses(cloud, [cloud], UP)[0]
    turned = cloud @ rest.rotation.T
    assert np.ptp(turned[:, 2]) < 0.7 * np.ptp(cloud[:, 2])


def test_places_keep_within_the_reach_of_the_arm():
    scene = on_table(can=tilted(can(), 0.0))
    base = np.eye(4)
    base[0, 3] = -0.5
    away = [
        float(np.linalg.norm(after(scene, "can", place.pose_before_to_after).mean(axis=0)[:2] - base[:2, 3]))
        for place in placements("can", scene, pose_base_to_world=base)
    ]
    assert len(away) > 5
    assert 0.25 < min(away) and max(away) < 0.75


def test_no_room_gives_no_placement():
    assert placements("can", on_table(0.2, can=tilted(can(), 0.0)))
    assert placements("can", on_table(0.08, can=tilted(can(), 0.0))) == []


def test_an_unknown_object_is_named():
    with pytest.raises(UnknownObject, match="cup"):
        placements("cup", on_table(can=tilted(can(), 0.0)))


def test_a_block_stands_on_another_one():
    block = box("block", (0.05, 0.05, 0.05))
    scene = on_table(a=tilted(block, 0.0), b=tilted(block, 0.0, aside=0.2))
    best = placements_on("a", scene, "b")[0]
    cloud = after(scene, "a", best.pose_before_to_after)
    assert np.linalg.norm(cloud.mean(axis=0)[:2] - [0.2, 0.0]) < 0.01
    assert 0.05 <= cloud[:, 2].min() < 0.06


def test_a_lemon_goes_into_a_bowl():
    scene = on_table(lemon=tilted(lemon(), 0.0), bowl=tilted(bowl(), 0.0, aside=0.25))
    best = placements_on("lemon", scene, "bowl", "within")[0]
    cloud = after(scene, "lemon", best.pose_before_to_after)
    assert np.linalg.norm(cloud.mean(axis=0)[:2] - [0.25, 0.0]) < 0.04
    assert cloud[:, 2].min() < 0.045


@pytest.mark.slow
def test_a_can_does_not_stand_on_a_narrow_ridge():
    def upright(width: float) -> int:
        ridge = box("ridge", (0.20, width, 0.12))
        scene = on_table(can=tilted(can(), 0.0), ridge=tilted(ridge, 0.0, aside=0.25))
        return sum("turned 0 deg" in place.rest for place in placements_on("can", scene, "ridge"))

    assert upright(0.1) > 0
    assert upright(0.008) == 0


def test_an_unseen_underside_is_filled_down_to_what_carries():
    top = tilted(box("box", (0.1, 0.1, 0.06)), 0.0)
    top = top[top[:, 2] > 0.055]
    scene = on_table(box=top)
    assert hidden_depth("box", scene, UP) == pytest.approx(0.057, abs=0.005)
    assert min(float(part[:, 2].min()) for part in solids_of(scene)["box"]) == pytest.approx(0.0, abs=0.005)


def test_a_spoon_that_touches_the_table_at_one_end_hides_nothing():
    assert hidden_depth("spoon", on_table(spoon=tilted(spoon(), 0.2)), UP) == 0.0


def test_a_noisy_table_is_a_slab_whose_top_is_its_plane():
    scene = on_table(can=tilted(can(), 0.0))
    noisy = scene.clouds["table"] + np.random.default_rng(0).normal(0.0, 0.002, scene.clouds["table"].shape)
    found = tops_of(noisy, UP)
    assert found.flat
    assert abs(found.tops[0].height) < 5e-4
    (slab,) = fixed_parts(noisy, UP)
    assert abs(slab[:, 2].max()) < 2e-3


def test_a_can_that_lies_is_stood_up_and_only_then_laid_on_its_round_side():
    cloud = tilted(can(), 1.35)
    rests = resting_poses(cloud, [cloud], UP)
    assert not rests[0].rolls
    assert rests[0].barrier > 0.003
    assert np.ptp(cloud @ rests[0].rotation.T @ UP) == pytest.approx(
        np.ptp(tilted(can(), 0.0)[:, 2]), abs=0.01
    )
    assert any(rest.rolls and rest.barrier < 0.001 for rest in rests)


def test_what_cannot_roll_comes_first_of_all_placements():
    rolls = [place.rolls for place in placements("can", on_table(can=tilted(can(), 1.35)))]
    assert not rolls[0]
    assert rolls == sorted(rolls)


def beside(size: float, aside: float) -> Scene:
    block = tilted(box("box", (0.05, 0.05, 0.05)), 0.0, aside=aside)
    return on_table(size, can=tilted(can(), 0.0, aside=-aside), box=block)


def test_places_keep_off_the_way_out_of_what_is_still_to_be_taken():
    scene = beside(0.24, 0.1)
    block = scene.clouds["box"][::10, None, :2]

    def nearest(remaining: tuple[str, ...]) -> float:
        found = placements("can", scene, remaining=remaining)
        clouds = [after(scene, "can", place.pose_before_to_after)[::5, :2] for place in found]
        return min(float(np.linalg.norm(cloud - block, axis=2).min()) for cloud in clouds)

    assert nearest(()) < 0.08
    assert nearest(("box",)) > 0.09  # half an open hand's width, less a cell


def test_where_all_room_is_on_a_way_out_there_is_none():
    assert placements("can", beside(0.15, 0.06))
    assert placements("can", beside(0.15, 0.06), remaining=("box",)) == []


def test_a_wall_has_no_top_and_is_filled_all_the_same():
    across, up = np.meshgrid(np.arange(-0.3, 0.3, 0.005), np.arange(0.0, 0.3, 0.005))
    wall = np.stack([np.full(across.size, 0.4), across.ravel(), up.ravel()], axis=1)
    assert tops_of(wall, UP).tops == ()
    corners = np.vstack(fixed_parts(wall, UP))
    assert np.allclose(np.ptp(corners, axis=0), [0.0, 0.6, 0.3], atol=0.02)
