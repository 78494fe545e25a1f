"""Masks in the forms of SAM's output, of a rendered scene: the labels come back, and wrong ones are said."""

import json
import pickle
from typing import Any

import numpy as np
import pytest
from run_lengths import lengths

from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology import DepthImage, InvalidInput, load_scene, scene_from_rgbd, scene_from_sam
from topple.topology.base.arrays import BoolArray

NAMES = ("crate", "carton", "can", "table")


@pytest.fixture(scope="module")
def seen() -> DepthImage:
    with World() as world:
        world.add_table(size=(2.0, 2.0))
        world.add(shapes.box("crate", (0.16, 0.12, 0.08)), pose_at(0, 0, 0), fixed=True)
        world.add(shapes.box("carton", (0.08, 0.06, 0.1)), pose_at(0.02, 0, 0.08), fixed=True)
        world.add(shapes.can("can"), pose_at(0.02, 0.2, 0.0), fixed=True)
        return Camera.looking_at((0.4, 0.1, 0.45), (0.0, 0.05, 0.05)).look(world, np.random.default_rng(0))


def stack(seen: DepthImage) -> BoolArray:
    numbers = {name: number for number, name in seen.names.items()}
    return np.array([seen.label == numbers[name] for name in NAMES])


def output(masks: BoolArray, as_runs: bool = False) -> list[dict[str, Any]]:
    """A list as `SamAutomaticMaskGenerator.generate` returns it."""
    return [
        {
            "segmentation": {"size": list(mask.shape), "counts": lengths(mask)} if as_runs else mask,
            "area": int(mask.sum()),
            "predicted_iou": 0.9 + 0.01 * k,
            "stability_score": 0.97,
        }
        for k, mask in enumerate(masks)
    ]


def pose(seen: DepthImage) -> dict[str, Any]:
    return {"pose_camera_to_world": seen.pose_camera_to_world}


@pytest.mark.parametrize("form", ["arrays", "runs", "stack", "stack with a channel"])
def test_each_form_gives_the_clouds_of_the_labels(seen, form):
    masks = stack(seen)
    given = {"arrays": output(masks), "runs": output(masks, True), "stack": masks}.get(form, masks[:, None])
    scene = scene_from_sam(seen.depth, seen.K, given, **pose(seen))
    label = sum((k + 1) * mask.astype(int) for k, mask in enumerate(masks[:3]))
    same = scene_from_rgbd(seen.depth, seen.K, label, **pose(seen))
    assert scene.movable == ("1", "2", "3") == same.movable
    assert all(np.array_equal(scene.clouds[name], same.clouds[name]) for name in scene.names)
    assert scene.fixed == {"table"} and scene.up is not None and abs(scene.up[2] - 1.0) < 0.01
    assert scene.wrong_masks == ()
    assert any("masks 4 reach across the picture" in text for text in scene.assumptions)


def test_what_a_segmentation_of_everything_adds_is_left_out_and_said(seen):
    masks = stack(seen)
    print_on_it = np.zeros_like(masks[0])
    print_on_it[tuple(np.argwhere(masks[1])[200])] = True
    around = masks[0] | masks[1]
    again = masks[2].copy()
    again[np.argwhere(again)[:15].T[0], np.argwhere(again)[:15].T[1]] = False
    given = output(np.array([*masks, print_on_it, around, again]))
    scene = scene_from_sam(seen.depth, seen.K, given, **pose(seen))
    assert scene.movable == ("1", "2", "7"), "of two of one region the better one by predicted_iou is taken"
    said = " ".join(scene.assumptions)
    assert "masks 3 show a region again" in said
    assert "masks 5, 6 have fewer than 60 pixels of depth of their own" in said
    plain = scene_from_sam(seen.depth, seen.K, output(masks), **pose(seen))
    assert np.array_equal(scene.clouds["2"], plain.clouds["2"]), "what the fragment covered is seen again"


def test_depth_says_which_masks_cannot_be_trusted(seen):
    masks = stack(seen)
    columns = np.indices(masks[2].shape)[1]
    left = masks[2] & (columns < np.median(columns[masks[2]]))
    spoilt = np.array([masks[0], masks[1], left, masks[2] & ~left])
    scene = scene_from_sam(seen.depth, seen.K, output(spoilt), **pose(seen))
    assert [wrong.names for wrong in scene.wrong_masks] == [("3", "4")]
    assert "one object in two masks" in str(scene.wrong_masks[0])


@pytest.mark.parametrize("form", ["masks.json", "annotations.json", "masks.npy", "masks.npz"])
def test_masks_are_read_from_a_file_beside_the_frame(seen, form, tmp_path, typed):
    masks, file, frame = stack(seen), tmp_path / form, tmp_path / "frame.npz"
    np.savez(frame, depth=seen.depth, K=seen.K, **pose(seen))
    if form == "masks.npy":
        np.save(file, masks)
    elif form == "masks.npz":
        np.savez(file, masks=masks, scores=np.ones(4))
    else:
        told = output(masks, True)
        file.write_text(json.dumps({"annotations": told} if form.startswith("ann") else told))
    scene = load_scene(frame, masks=str(file))
    same = scene_from_sam(seen.depth, seen.K, masks, **pose(seen))
    assert scene.names == same.names
    assert all(np.array_equal(scene.clouds[name], same.clouds[name]) for name in scene.names)
    if form == "masks.json":
        found = typed("order", frame, "--masks", file, "--target", "1", "--json").document
        assert found["order"] == ["2", "1"]


def test_pickles_and_other_files_are_refused(seen, tmp_path):
    frame, file = tmp_path / "frame.npz", tmp_path / "masks"
    np.savez(frame, depth=seen.depth, K=seen.K)
    np.save(tmp_path / "list.npy", np.array(output(stack(seen)), dtype=object))
    np.savez(tmp_path / "two.npz", a=[1], b=[2])
    file.write_bytes(pickle.dumps(output(stack(seen))))
    for name, said in (
        ("masks", "never loaded"),
        ("list.npy", "never loaded"),
        ("two.npz", "or an array masks"),
        ("none.npy", "cannot be read"),
    ):
        with pytest.raises(InvalidInput, match=said):
            load_scene(frame, masks=tmp_path / name)
    (tmp_path / "m.json").write_text("{}")
    with pytest.raises(InvalidInput, match="expected a list"):
        load_scene(frame, masks=tmp_path / "m.json")
    np.savez(frame, depth=seen.depth, K=seen.K, label=seen.label)
    np.save(tmp_path / "m.npy", stack(seen))
    with pytest.raises(InvalidInput, match="expected depth and K"):
        load_scene(frame, masks=tmp_path / "m.npy")


@pytest.mark.parametrize(
    ("masks", "said"),
    [
        (np.zeros((2, 5, 5), dtype=bool), "expected one size"),
        ([{"segmentation": np.zeros((5, 5), dtype=bool)}], "expected the image's size"),
        ([{"segmentation": "yes"}], "has no segmentation"),
        ([], "expected"),
        (np.zeros((3, 480, 640), dtype=bool), "none of 3 masks is of an object"),
    ],
)
def test_what_is_no_mask_is_refused(masks, said):
    with pytest.raises(InvalidInput, match=said):
        scene_from_sam(np.ones((480, 640)), np.diag([500.0, 500.0, 1.0]), masks)
