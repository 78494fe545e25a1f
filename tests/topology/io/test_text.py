"""Text: clouds with headings, counts and commas, and numbers that are no cloud."""

from pathlib import Path

import numpy as np
import pytest

from topple.topology.base.errors import InvalidInput
from topple.topology.io import load_scene

POINTS = np.round(np.random.default_rng(5).uniform(-0.1, 0.2, (30, 3)), 5)
COLOURS = np.random.default_rng(6).integers(0, 255, (30, 3))


def _rows(mark: str = " ", more: bool = True) -> list[str]:
    table = zip(POINTS.tolist(), COLOURS.tolist(), strict=True)
    return [mark.join([*(f"{v:.5f}" for v in xyz), *(map(str, rgb) if more else ())]) for xyz, rgb in table]


def _folder(at: Path, name: str, lines: list[str]) -> Path:
    (at / "cup.xyz").write_text("\n".join(f"{x} {y} {z}" for x, y, z in POINTS + 1.0))
    (at / name).write_text("\n".join(lines) + "\n")
    return at


TEXTS = {
    "a comment as heading, and a count": ("a.txt", ["//X Y Z R G B", "30", *_rows()]),
    "names of columns": ("a.csv", ["x,y,z,r,g,b", *_rows(",")]),
    "quoted names with units": ("a.csv", ['"X [m]";"Y [m]";"Z [m]"', *_rows(";", False)]),
    "a count": ("a.pts", ["30", *_rows()]),
    "no heading": ("a.asc", _rows("\t")),
    "an index before": ("a.csv", [",x,y,z", *(f"{k},{row}" for k, row in enumerate(_rows(",", False)))]),
    "numbers as names": ("a.csv", ["0,1,2", *_rows(",", False)]),
    "decimal commas": ("a.csv", ["x;y;z", *(row.replace(".", ",") for row in _rows(";", False))]),
    "decimal commas, apart by tabs": ("a.txt", [row.replace(".", ",") for row in _rows("\t", False)]),
    "three lines of heading": ("a.txt", ["exported by a tool", "on a day", "x y z", *_rows(" ", False)]),
    "another order": ("a.csv", ["id,z,y,x", *(f"7,{z},{y},{x}" for x, y, z in POINTS)]),
}


@pytest.mark.parametrize("name", TEXTS)
def test_clouds_as_text_are_read_whatever_stands_above_them(tmp_path, name):
    scene = load_scene(_folder(tmp_path, *TEXTS[name]))
    assert scene.names == ("a", "cup") and not any("not used" in note for note in scene.assumptions)
    assert scene.clouds["a"] == pytest.approx(POINTS, abs=1e-9)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["31", *_rows()], "'a' .a.txt. declares 31 points and has 30: write it again"),
        (["x y z", *_rows(), "and so on"], "reads 'and so on' in line 32: expected x y z"),
        (["0.05 0x10 0.003en", *_rows()], "reads '0.05 0x10 0.003en' in line 1: expected x y z"),
        (["0.0510.0.0637", *_rows()], "reads '0.0510.0.0637' in line 1: expected x y z"),
    ],
)
def test_what_is_no_whole_cloud_is_refused_in_a_line(tmp_path, lines, words):
    with pytest.raises(InvalidInput, match=words):
        load_scene(_folder(tmp_path, "a.txt", lines))


def _table(values: np.ndarray) -> list[str]:
    return [" ".join(f"{value:.6f}" for value in row) for row in np.atleast_2d(values)]


POSE = np.array([[0.0, -1, 0, 0.4], [1, 0, 0, -0.3], [0, 0, 1, 0.6], [0, 0, 0, 1]])
TURN = np.array([0.5, 0.5, 0.5, 0.5])
WAY = np.array([[1.0 + k, 0.1 * k, 0, 0.5, *TURN] for k in range(9)])
NUMBERS = {
    "pose.txt": (_table(POSE), "a 4 x 4 matrix"),
    "pose.xyz": (_table(POSE), "a 4 x 4 matrix"),
    "pose34.txt": (["camera to world", *_table(POSE[:3])], "a 3 x 4 matrix"),
    "K.csv": (["525,0,320", "0,525,240", "0,0,1"], "a 3 x 3 matrix"),
    "tum.txt": (["# timestamp tx ty tz qx qy qz qw", *_table(WAY)], "a trajectory"),
    "placed.csv": (_table(WAY[:, 1:]), "a trajectory"),
    "kitti.txt": (_table(np.tile(POSE[:3].ravel(), (6, 1))), "a trajectory"),
    "poses.txt": (_table(np.tile(POSE, (5, 1))), "a trajectory"),
    "times.txt": (_table(WAY[:, :4] + [1.5e9, 0, 0, 0]), "a trajectory"),
    "plane.txt": (["0 0 1 -0.02"], "1 x 4 numbers"),
}


@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_that_are_no_cloud_are_no_object(tmp_path, name):
    lines, kind = NUMBERS[name]
    scene = load_scene(_folder(tmp_path, name, lines))
    assert scene.names == ("cup",)
    assert f"not used, being no cloud or mesh: {name} ({kind})" in scene.assumptions


def test_points_with_normals_and_curvature_are_no_trajectory(tmp_path):
    flat = np.column_stack([POINTS, np.tile([0.0, 0, 1, 0], (30, 1))])
    assert load_scene(_folder(tmp_path, "a.txt", _table(flat))).names == ("a", "cup")
