from pathlib import Path

import numpy as np
import pytest

from topple.topology import InvalidInput, load_sequence, relate

RNG = np.random.default_rng(0)
CUBE = RNG.integers(0, 600, (300, 3)).astype(np.int16)  # 6 cm, in tenths of a millimetre


def recording(path: Path, **changes: object) -> Path:
    """Two frames: a cube on the table, then 10 cm above it."""
    arrays = {
        "cube_xyz_01mm": np.concatenate([CUBE, CUBE + np.array([0, 0, 1000])]).astype(np.int16),
        "cube_offsets": np.array([0, 300, 600]),
        "table_plane": np.array([0, 0, 1.0, 0]),
        "viewpoints": np.array([[0, 0, 1.0]]),
        **changes,
    }
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    return path


def test_frames_of_a_recording_share_what_does_not_change(tmp_path):
    first, second = load_sequence(recording(tmp_path / "r.npz"))
    assert first.names == second.names == ("cube", "table")
    assert first.clouds["table"] is second.clouds["table"]
    np.testing.assert_allclose(second.clouds["cube"] - first.clouds["cube"], np.tile([0, 0, 0.1], (300, 1)))
    followed = relate(first).followed(second)
    assert followed.between("cube", "table").relation == "disjoint"
    assert followed.to_json() == relate(second, deviation=followed.deviation).to_json()


def test_an_object_nobody_saw_is_absent_from_the_frame(tmp_path):
    ball = {"ball_xyz_01mm": CUBE, "ball_offsets": np.array([0, 300, 300])}
    first, second = load_sequence(recording(tmp_path / "r.npz", **ball))
    assert set(first.names) - set(second.names) == {"ball"}
    with pytest.raises(InvalidInput, match="the frame has cube, table, expected cube, ball, table"):
        relate(first).followed(second)


def test_a_folder_is_read_in_the_order_of_its_names(tmp_path):
    for number in (2, 1):
        np.savez(tmp_path / f"frame_{number}.npz", cube=CUBE * 1e-4 + number)
    assert [scene.clouds["cube"].min() > 1.5 for scene in load_sequence(tmp_path)] == [False, True]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"cube_offsets": None}, "object 'cube' has no cube_offsets"),
        ({"cube_offsets": np.array([0, 400, 300])}, "does not rise"),
        ({"cube_offsets": np.array([0, 300, 900])}, "does not rise from 0 to the 600 rows"),
        ({"cube_xyz_01mm": None}, "no tracked objects among the arrays"),
        ({"cube_xyz_01mm": np.full((600, 3), np.nan)}, "NaN"),
    ],
)
def test_what_is_no_recording_is_refused_with_the_file_s_name(tmp_path, changes, message):
    path = recording(tmp_path / "r.npz", **changes)
    with pytest.raises(InvalidInput, match=message) as refused:
        list(load_sequence(path))
    assert str(refused.value).startswith(str(path))


def test_an_empty_folder_is_no_sequence(tmp_path):
    with pytest.raises(InvalidInput, match="the folder is empty"):
        list(load_sequence(tmp_path))
