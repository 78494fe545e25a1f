"""Views with poses off by 5 cm and 5 degrees become one scene; what cannot be trusted is refused."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from topple.robots import scenario
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import box
from topple.topology.base.errors import InvalidInput
from topple.topology.merging.merge import merge_views
from topple.topology.merging.register import register
from topple.topology.merging.segments import outliers, segment_cloud
from topple.topology.views.image import DepthImage

pytest.importorskip("small_gicp", reason="small_gicp is not installed: pip install '.[views]'")


def looked(name: str, seed: int) -> list[DepthImage]:
    """What three cameras with a Kinect's noise see of a scene."""
    rng = np.random.default_rng(seed)
    with scenario(name, seed) as stage:
        return [camera.look(stage.world, rng) for camera in stage.cameras]


@pytest.fixture(scope="module")
def pile() -> list[DepthImage]:
    """A box, two cans and two spoons, some on top of others."""
    return looked("pile", 1)


def off(image: DepthImage, seed: int, metres: float = 0.05, degrees: float = 5.0) -> DepthImage:
    """The view at a wrong pose, in any direction."""
    rng = np.random.default_rng(seed)
    axis, along = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    wrong = np.eye(4)
    wrong[:3, :3] = Rotation.from_rotvec(np.radians(degrees) * axis).as_matrix()
    wrong[:3, 3] = metres * along
    return replace(image, pose_camera_to_world=wrong @ image.pose_camera_to_world)


def all_off(images: list[DepthImage], **by: float) -> list[DepthImage]:
    return [images[0], *(off(image, seed, **by) for seed, image in enumerate(images[1:]))]


def unmasked(images: list[DepthImage]) -> list[DepthImage]:
    return [replace(image, label=np.zeros_like(image.label)) for image in images]


def errors(found: DepthImage, true: DepthImage) -> tuple[float, float]:
    """Distance [m] in the middle of the table and angle [rad] of two poses of one camera."""
    between = found.pose_camera_to_world @ np.linalg.inv(true.pose_camera_to_world)
    turn = Rotation.from_matrix(between[:3, :3]).magnitude()
    return float(np.linalg.norm(between[:3, 3])), float(turn)


def test_poses_come_back_within_six_millimetres_and_two_degrees(pile):
    merged = merge_views(all_off(pile), same_labels=True)
    assert len(merged.registrations) == 2
    for found, true, fit in zip(merged.scene.images[1:], pile[1:], merged.registrations, strict=True):
        distance, angle = errors(found, true)
        assert distance < 0.006 and angle < np.radians(2)
        assert 0.001 < fit.residual < 0.003 and fit.conflict < 0.05 and fit.common > 1000
    assert np.array_equal(merged.scene.images[0].pose_camera_to_world, pile[0].pose_camera_to_world)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seed"), [("dishes", 0), ("tower", 0), ("lemon", 1), ("pile", 3), ("pile", 5)]
)
def test_poses_come_back_in_other_scenes(name, seed):
    images = looked(name, seed)
    merged = merge_views(all_off(images), same_labels=True)
    for found, true in zip(merged.scene.images[1:], images[1:], strict=True):
        distance, angle = errors(found, true)
        assert distance < 0.006 and angle < np.radians(2)


def test_masks_that_number_the_objects_differently_are_matched_by_their_surface(pile):
    views = []
    for turn, image in enumerate(all_off(pile)):
        labels = [int(label) for label in np.unique(image.label) if label]
        other = dict(zip(labels, np.roll(labels, turn).tolist(), strict=True))
        label = np.zeros_like(image.label)
        for old, new in other.items():
            label[image.label == old] = new
        views.append(replace(image, label=label, names={other[k]: image.name_of(k) for k in labels}))
    scene = merge_views(views).scene
    true = {name for image in pile for name in image.clouds()}
    assert set(scene.names) == true and scene.fixed == {"table"}
    for image in scene.images:  # no object took another one's pixels in any view
        truth = pile[[np.array_equal(image.depth, one.depth) for one in pile].index(True)]
        for number, name in image.names.items():
            if name != "table" and (mine := image.label == number).any():
                names, counts = np.unique(truth.label[mine], return_counts=True)
                assert truth.name_of(int(names[counts.argmax()])) == name


def test_without_masks_what_stands_apart_is_told_apart():
    blocks = looked("tower", 0)
    merged = merge_views(unmasked(all_off(blocks)))
    assert not merged.masked and merged.loose < 0.05 and merged.outliers < 0.05
    true = _true(blocks)
    stacks = (("yellow", "green"), ("blue", "red"))
    apart = [np.vstack([true[name] for name in names]) for names in stacks]
    assert len(merged.scene.movable) == len(apart)
    for cloud in apart:
        middles = [merged.scene.clouds[one].mean(axis=0) for one in merged.scene.movable]
        assert min(np.linalg.norm(middle - cloud.mean(axis=0)) for middle in middles) < 0.02
    assert merged.scene.up is not None and merged.scene.up[2] > 0.999
    assert any("no masks" in note for note in merged.scene.assumptions)


def _true(images: list[DepthImage]) -> dict[str, np.ndarray]:
    clouds: dict[str, list[np.ndarray]] = {}
    for image in images:
        for name, cloud in image.clouds().items():
            clouds.setdefault(name, []).append(cloud)
    return {name: np.concatenate(parts) for name, parts in clouds.items() if name != "table"}


def test_a_pose_too_far_off_is_refused_with_its_residual(pile):
    far = off(pile[1], 0, 0.0, 0.0)
    pose = far.pose_camera_to_world.copy()
    pose[:2, 3] += [0.2, -0.2]
    with pytest.raises(InvalidInput, match=r"view 2 does not fit .*(looked through|in common|residual)"):
        merge_views([pile[0], replace(far, pose_camera_to_world=pose)], same_labels=True)


@pytest.mark.slow
def test_a_view_of_another_scene_is_refused(pile):
    with pytest.raises(InvalidInput, match="view 3 does not fit the views before it"):
        merge_views([pile[0], pile[1], looked("dishes", 0)[2]], same_labels=True)


def test_what_is_no_set_of_views_is_refused(pile):
    with pytest.raises(InvalidInput, match="1 views and 1 names: expected two views or more"):
        merge_views(pile[:1])
    with pytest.raises(InvalidInput, match="view 2 has no mask and others have one"):
        merge_views([pile[0], *unmasked(pile[1:2])])
    empty = replace(pile[1], depth=np.zeros_like(pile[1].depth))
    with pytest.raises(InvalidInput, match="view 2 has depth in 0 pixels"):
        merge_views([pile[0], empty])
    tilted = off(pile[1], 4, 0.0, 40.0)
    with pytest.raises(InvalidInput, match=r"view 2.*tilted by \d+ degrees"):
        merge_views([pile[0], tilted])


def test_a_cloud_is_cut_where_it_bends_inwards_and_nowhere_else():
    grid = np.stack(np.meshgrid(np.arange(0, 0.1, 0.005), np.arange(0, 0.1, 0.005)), axis=-1).reshape(-1, 2)
    roof = np.column_stack([grid, -np.abs(grid[:, 0] - 0.05)])  # seen from above, its ridge bends outwards
    eyes = np.tile([0.05, 0.05, 1.0], (len(grid), 1))
    assert set(segment_cloud(roof, eyes)) == {0}
    valley = roof * [1, 1, -1]
    assert set(segment_cloud(valley, eyes)) - {-1} == {0, 1}


def test_single_returns_in_the_air_are_outliers_and_surfaces_are_not():
    grid = np.stack(np.meshgrid(np.arange(0, 0.2, 0.005), np.arange(0, 0.2, 0.005)), axis=-1).reshape(-1, 2)
    flat = np.column_stack([grid, np.zeros(len(grid))])
    flying = np.array([[0.1, 0.1, 0.05], [0.02, 0.1, 0.08]])
    stray = outliers(np.concatenate([flat, flying]))
    assert stray[-2:].all() and stray[:-2].mean() < 0.01


def test_without_small_gicp_its_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "small_gicp", None)
    with pytest.raises(InvalidInput, match=r"needs small_gicp: pip install 'small-gicp>=1\.0'$"):
        register((), (), ())


def test_what_no_mask_names_is_matter_of_the_merged_scene():
    rng = np.random.default_rng(0)
    with scenario("pile", 1) as stage:
        stage.world.add(box("wall", (0.02, 0.8, 0.5)), pose_at(-0.4, 0.0, 0.0), fixed=True)
        images = [camera.look(stage.world, rng) for camera in stage.cameras[:2]]
    views = [
        replace(image, label=np.where(image.label == _number(image, "wall"), 0, image.label))
        for image in images
    ]
    scene = merge_views(views, same_labels=True).scene
    assert "wall" not in scene.names and not any("unnamed" in name for name in scene.names)
    assert len(scene.matter) > 500
    assert np.abs(scene.matter[:, 0] + 0.39).max() < 0.05


def _number(image: DepthImage, name: str) -> int:
    return next(number for number, called in image.names.items() if called == name)
