"""What a segmentation gives: labelled points, stacks of masks, names of labels, labelled PCD files."""

from pathlib import Path

import numpy as np
import pytest

from topple.topology import InvalidInput, load_scene

RNG = np.random.default_rng(0)
BOX = RNG.uniform((-0.05, -0.05, 0), (0.05, 0.05, 0.1), (400, 3))
FLAT = np.column_stack([RNG.uniform(-0.4, 0.4, (6000, 2)), np.zeros(6000)])
ASIDE = np.array([0.2, 0, 0])
POINTS = np.concatenate([FLAT, BOX, BOX + ASIDE])
LABELS = np.repeat([0, 3, 5], [6000, 400, 400])


def _saved(folder: Path, **arrays: object) -> Path:
    np.savez(folder / "scene.npz", **arrays)  # type: ignore[arg-type]
    return folder / "scene.npz"


def _frame(**changes: object) -> dict[str, object]:
    """A camera straight above a table that has no label, with two boxes of 10 cm on it."""
    depth, label = np.ones((120, 160)), np.zeros((120, 160), dtype=int)
    for number, (row, column) in enumerate(((40, 40), (60, 100)), start=1):
        depth[row : row + 20, column : column + 20] = 0.9
        label[row : row + 20, column : column + 20] = number
    frame = {"depth": depth, "K": np.array([[150.0, 0, 80], [0, 150.0, 60], [0, 0, 1]]), "label": label}
    return {key: value for key, value in {**frame, **changes}.items() if value is not None}


def test_labelled_points_are_an_object_per_label_on_the_table_of_the_background(tmp_path):
    scene = load_scene(_saved(tmp_path, points=POINTS, labels=LABELS, viewpoints=[[0.5, -0.5, 0.8]]))
    assert scene.names == ("3", "5", "table")
    assert scene.fixed == {"table"}
    assert np.array_equal(scene.clouds["5"], POINTS[LABELS == 5])
    assert np.allclose(np.asarray(scene.up), [0, 0, 1])


def test_an_object_may_be_called_points(tmp_path):
    assert load_scene(_saved(tmp_path, points=BOX, labels=BOX + 0.3)).names == ("points", "labels")


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"labels": LABELS[:-1]}, r"\(6800, 3\).*\(6799,\)"),
        ({"labels": LABELS * 0.5}, "whole numbers"),
        ({"labels": LABELS * 0}, "0 everywhere"),
        ({"names": np.array(["floor", "a", "b"])}, "3 entries and the labels reach 5"),
        ({"names": np.array(["mug", "mug"]), "ids": np.array([3, 5])}, "share a name"),
        ({"names": np.array(["a", "b"]), "ids": np.array([3, 3])}, "twice"),
    ],
)
def test_labelled_points_that_do_not_fit_are_refused(tmp_path, arrays, words):
    with pytest.raises(InvalidInput, match=words):
        load_scene(_saved(tmp_path, **({"points": POINTS, "labels": LABELS} | arrays)))


def test_names_are_those_of_the_labels(tmp_path):
    names = np.array(["background", "mug", ""])
    assert load_scene(_saved(tmp_path, **_frame(names=names))).names == ("mug", "2", "table")
    pairs = {"names": np.array(["can", "mug"]), "ids": np.array([2, 1]), "fixed": np.array([2])}
    scene = load_scene(_saved(tmp_path, **_frame(**pairs)))
    assert scene.names == ("mug", "can")
    assert scene.fixed == {"can"}


def test_an_array_that_is_not_used_is_said(tmp_path):
    frame = load_scene(_saved(tmp_path, **_frame(poses=np.eye(4), scores=np.ones(2))))
    assert "not used, being unknown: the arrays poses, scores" in frame.assumptions
    clouds = load_scene(_saved(tmp_path, mug=BOX, source=np.array("a camera")))
    assert "not used, being unknown: the array source" in clouds.assumptions


def test_a_stack_of_masks_is_a_label_per_mask(tmp_path):
    frame = _frame()
    label = np.asarray(frame.pop("label"))
    masks = np.stack([label == 1, label == 2])
    scene = load_scene(_saved(tmp_path, **frame, masks=masks))
    assert scene.names == ("1", "2", "table")
    assert len(scene.clouds["1"]) == 400
    for broken, words in ((masks[0], "N, H, W"), (masks & masks[:1], "empty")):
        with pytest.raises(InvalidInput, match=words):
            load_scene(_saved(tmp_path, **frame, masks=broken))
    with pytest.raises(InvalidInput, match="one mask"):
        load_scene(_saved(tmp_path, **frame, masks=masks, label=label))


def _pcd(path: Path, height: int, field: str, viewpoint: str) -> Path:
    rows = [f"{x:.5f} {y:.5f} {z:.5f} {label}" for (x, y, z), label in zip(POINTS, LABELS, strict=True)]
    header = (
        f"# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z {field}\nSIZE 4 4 4 4\n"
        f"TYPE F F F U\nCOUNT 1 1 1 1\nWIDTH {len(rows) // height}\nHEIGHT {height}\n"
        f"VIEWPOINT {viewpoint} 1 0 0 0\nPOINTS {len(rows)}\nDATA ascii\n"
    )
    path.write_text(header + "\n".join(rows) + "\n", encoding="ascii")
    return path


@pytest.mark.parametrize("field", ["label", "object_id"])
def test_a_labelled_pcd_file_is_a_scene(tmp_path, field):
    scene = load_scene(_pcd(tmp_path / "scene.pcd", 1, field, "0.5 -0.5 0.8"))
    assert scene.names == ("3", "5", "table")
    assert scene.viewpoints.tolist() == [[0.5, -0.5, 0.8]]


def test_the_origin_is_a_camera_only_of_an_organised_pcd_file(tmp_path):
    assert len(load_scene(_pcd(tmp_path / "a.pcd", 1, "label", "0 0 0")).viewpoints) == 0
    assert load_scene(_pcd(tmp_path / "b.pcd", 100, "label", "0 0 0"), up=(0, 0, 1)).viewpoints.tolist() == [
        [0, 0, 0]
    ]


def test_a_pcd_file_without_labels_is_no_scene(tmp_path):
    with pytest.raises(InvalidInput, match=r"no label.*folder"):
        load_scene(_pcd(tmp_path / "scene.pcd", 1, "intensity", "0 0 0"))


def test_what_a_folder_holds_is_used_or_said(tmp_path):
    np.savetxt(tmp_path / "mug.xyz", BOX)
    np.savetxt(tmp_path / "can.txt", BOX + ASIDE)
    (tmp_path / "README.txt").write_text("Taken on Monday.\n", encoding="utf-8")
    (tmp_path / "view.jpg").write_bytes(b"\xff\xd8\xff")
    (tmp_path / "old").mkdir()
    scene = load_scene(tmp_path)
    assert set(scene.names) == {"mug", "can"}
    assert "not used, being no cloud or mesh: README.txt, old/, view.jpg" in scene.assumptions


def test_centimetres_are_asked_for(tmp_path):
    table = np.column_stack([RNG.uniform(-8, 8, (2000, 2)), np.zeros(2000)])
    with pytest.raises(InvalidInput, match="centimetres"):
        load_scene(_saved(tmp_path, mug=BOX * 100, can=BOX * 60 + 9, table=table))


def test_large_things_that_never_move_are_no_centimetres(tmp_path):
    floor, shelf = FLAT * 10, BOX * 30
    assert load_scene(_saved(tmp_path, mug=BOX, floor=floor, shelf=shelf)).names == ("mug", "floor", "shelf")
    assert load_scene(_saved(tmp_path, pallet=BOX * 12, crate=BOX * 11), fixed=["pallet"]).movable == (
        "crate",
    )


def test_what_the_background_has_beside_the_table_is_in_the_way(tmp_path):
    wall = np.column_stack([np.full(40_000, -0.3), RNG.uniform((-0.4, 0.0), (0.4, 0.5), (40_000, 2))])
    points, labels = np.concatenate([POINTS, wall]), np.append(LABELS, np.zeros(40_000, dtype=int))
    scene = load_scene(_saved(tmp_path, points=points, labels=labels, viewpoints=[[0.5, -0.5, 0.8]]))
    assert scene.names == ("3", "5", "table")
    assert np.abs(scene.matter[:, 0] + 0.3).max() < 1e-3
    assert len(scene.matter) > 0.9 * 80 * 49
    assert len(load_scene(_saved(tmp_path, points=POINTS, labels=LABELS, up=[0, 0, 1])).matter) == 0
