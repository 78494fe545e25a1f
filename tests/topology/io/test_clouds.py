"""An .npz of clouds as a scene: its keys, what is assumed, and what is refused."""

import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest

from topple.topology import Scene
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.io import load_scene

RNG = np.random.default_rng(0)
BOX = RNG.uniform(0, 0.1, (200, 3))
TABLE = np.column_stack([RNG.uniform(-0.5, 0.5, (2000, 2)), np.zeros(2000)])


def _save(folder: Path, **arrays: object) -> Path:
    path = folder / "scene.npz"
    np.savez(path, **arrays)  # type: ignore[arg-type]
    return path


def test_names_with_a_slash_are_names(tmp_path):
    path = _save(tmp_path, **{"full/mug": BOX, "full/table": TABLE}, fixed=np.array(["full/table"]))
    scene = load_scene(path)
    assert scene.names == ("full/mug", "full/table")
    assert scene.movable == ("full/mug",)


def test_optional_keys_are_no_objects(tmp_path):
    base = np.eye(4)
    base[:3, 3] = [0, -0.5, 0]
    scene = load_scene(
        _save(
            tmp_path,
            mug=BOX,
            desk=TABLE,
            up=[0, 0, 2.0],
            fixed="desk",
            viewpoints=[[0, 0, 1.0]],
            robot_base=base,
            source="a note",
        )
    )
    assert scene.names == ("mug", "desk")
    assert scene.fixed == {"desk"}
    assert scene.up is not None
    assert scene.up.tolist() == [0, 0, 1]
    assert scene.viewpoints.tolist() == [[0, 0, 1]]
    assert scene.robot_base is not None
    assert np.array_equal(scene.robot_base, base)


def test_given_fixed_names_join_the_files(tmp_path):
    path = _save(tmp_path, mug=BOX, desk=TABLE, wall=TABLE, fixed=["desk"])
    assert load_scene(path, fixed=["wall"]).fixed == {"desk", "wall"}
    assert load_scene(path, fixed="wall").fixed == {"desk", "wall"}


def test_up_comes_from_the_caller_then_the_file_then_the_plane_then_the_table(tmp_path):
    path = _save(tmp_path, mug=BOX, table=TABLE, table_plane=[0, 0, 1, 0], up=[0, 1, 0])
    assert load_scene(path, up=[1, 0, 0]).up.tolist() == [1, 0, 0]  # type: ignore[union-attr]
    assert load_scene(path).up.tolist() == [0, 1, 0]  # type: ignore[union-attr]
    scene = load_scene(_save(tmp_path, mug=BOX, table=TABLE, table_plane=[0, 0, 2, 0]))
    assert scene.up.tolist() == [0, 0, 1]  # type: ignore[union-attr]
    scene = load_scene(_save(tmp_path, mug=BOX, table=TABLE))
    assert np.allclose(scene.up, [0, 0, 1], atol=1e-6)  # type: ignore[arg-type]
    assert any("'table'" in line for line in scene.assumptions)
    assert load_scene(_save(tmp_path, mug=BOX)).up is None


def test_a_table_plane_without_a_table_lays_one_under_everything(tmp_path):
    normal = np.array([0.6, 0, 0.8])
    scene = load_scene(_save(tmp_path, mug=BOX, cup=BOX + 0.3, table_plane=[*normal, 0.05]))
    assert scene.fixed == {"table"}
    table = scene.clouds["table"]
    assert np.allclose(table @ normal + 0.05, 0, atol=1e-12)
    for name in ("mug", "cup"):
        shadow = scene.clouds[name] - np.outer(scene.clouds[name] @ normal + 0.05, normal)
        assert (shadow >= table.min(axis=0)).all()
        assert (shadow <= table.max(axis=0)).all()
    assert any("not a measured one" in line for line in scene.assumptions)


def test_a_laid_table_is_fine_around_the_objects_and_ends_a_metre_beyond_them(tmp_path):
    scene = load_scene(_save(tmp_path, mug=BOX, table_plane=[0, 0, 1, 0]))
    mug, table = scene.clouds["mug"][:, :2], scene.clouds["table"][:, :2]
    assert np.allclose(table.min(axis=0), mug.min(axis=0) - 1.0)
    assert np.allclose(table.max(axis=0), mug.max(axis=0) + 1.0)

    def spacing(beyond: float) -> float:
        """Largest distance to the table's next point along a line so far beyond the mug [m]."""
        y = np.linspace(mug[:, 1].min(), mug[:, 1].max(), 50)
        line = np.column_stack([np.full(50, mug[:, 0].max() + beyond), y])
        return float(np.linalg.norm(line[:, None] - table[None], axis=2).min(axis=1).max())

    assert spacing(0.09) < 0.004
    assert spacing(0.2) > 0.01


def test_a_flat_thing_on_the_plane_is_not_taken_for_the_table(tmp_path):
    spoon = RNG.uniform(0, 1, (300, 3)) * [0.2, 0.04, 0.003]
    tray = RNG.uniform(-1, 1, (300, 3)) * [0.19, 0.14, 0.002]
    scene = load_scene(_save(tmp_path, spoon=spoon, tray=tray, table_plane=[0, 0, 1, 0]))
    assert scene.fixed == {"table"}


def test_a_wide_cloud_in_the_plane_is_the_table(tmp_path):
    scene = load_scene(_save(tmp_path, mug=BOX, desk=TABLE, table_plane=[0, 0, 1, 0]))
    assert scene.names == ("mug", "desk")
    assert scene.fixed == {"desk"}


def test_an_empty_table_is_a_scene(tmp_path):
    scene = load_scene(_save(tmp_path, table=TABLE))
    assert scene.movable == ()


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"mug": np.empty((0, 3))}, "'mug' is empty"),
        ({"mug": np.zeros((1, 3))}, "'mug' has a single point"),
        ({"mug": np.where(BOX < 0.01, np.nan, BOX)}, "'mug' has NaN"),
        ({"mug": np.full((9, 3), np.nan)}, "'mug' has NaN.* 9 of 9"),
        ({"mug": BOX[:, :2]}, r"'mug' has shape \(200, 2\).*\(N, 3\)"),
        ({"mug": BOX * 1000}, "'mug' extends .*99.*more than 20 m.*millimetres: points / 1000"),
        ({"mug": BOX.astype(complex)}, "'mug' holds complex"),
        ({"frames": np.arange(5), "mug": BOX}, "'frames' has shape"),
        ({"mug": BOX, "up": [0, 0, 0]}, "up is"),
        ({"mug": BOX, "up": [0, 0, 1, 0]}, "up has shape"),
        ({"mug": BOX, "table_plane": [0, 0, 0, 1]}, "table_plane is"),
        ({"mug": BOX, "table_plane": [0, 0, 1]}, "table_plane has shape"),
        ({"mug": BOX, "viewpoints": [[0, 1]]}, "viewpoints has shape"),
        ({"mug": BOX, "robot_base": np.diag([1, -1, 1, 1])}, "robot_base is mirrored.*right-handed.*turn"),
        ({"mug": BOX, "robot_base": np.eye(4) * 1.1}, "robot_base"),
        ({"mug": BOX, "robot_base": np.diag([2, 2, 2, 1])}, "robot_base.*not rigid.*orthonormal.*scale"),
        ({"mug": BOX, "fixed": [0.5]}, "fixed holds"),
        ({"mug": BOX, "fixed": ["desk"]}, "unknown fixed object 'desk'"),
        ({"up": [0, 0, 1]}, "no clouds found"),
    ],
)
def test_bad_arrays_are_refused_with_file_and_key(tmp_path, arrays, words):
    path = _save(tmp_path, **arrays)
    with pytest.raises(InvalidInput, match=words) as refusal:
        load_scene(path)
    assert str(refusal.value).startswith(str(path))


def test_an_unknown_fixed_name_keeps_what_is_known(tmp_path):
    with pytest.raises(UnknownObject) as refusal:
        load_scene(_save(tmp_path, mug=BOX), fixed=["desk"])
    assert refusal.value.known == ("mug",)
    assert refusal.value.name == "desk"


class _Bomb:
    """Leaves a mark when it is unpickled."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[object, ...]:
        return (Path.touch, (self.mark,))


def test_a_pickle_is_refused_and_never_loaded(tmp_path):
    mark = tmp_path / "mark"
    bomb = np.empty(1, dtype=object)
    bomb[0] = _Bomb(mark)
    with pytest.raises(InvalidInput, match="'mug' holds a Python pickle"):
        load_scene(_save(tmp_path, mug=bomb))
    np.save(tmp_path / "frame.npy", bomb, allow_pickle=True)
    with pytest.raises(InvalidInput, match="pickle"):
        load_scene(tmp_path / "frame.npy")
    assert not mark.exists()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "empty"),
        (b"x y z\n0 0 0\n", "of no known format"),
        (b"\x89PNG\r\n\x1a\n", "PNG"),
        (b"\x80\x04\x95", "pickle"),
        (b"ply\nformat ascii 1.0\n", "PLY file: put it into a folder"),
        (b"PK\x03\x04 and no more", "broken .npz"),
        (b"\x93NUMPY\x01\x00", "broken"),
    ],
)
def test_a_file_that_is_not_what_it_says_is_refused(tmp_path, content, words):
    path = tmp_path / "scene.npz"
    path.write_bytes(content)
    with pytest.raises(InvalidInput, match=words):
        load_scene(path)


def test_content_decides_and_not_the_name(tmp_path):
    path = _save(tmp_path, mug=BOX).rename(tmp_path / "scene.dat")
    assert load_scene(path).names == ("mug",)


def test_a_cut_off_or_altered_archive_is_refused(tmp_path):
    path = _save(tmp_path, mug=BOX)
    content = bytearray(path.read_bytes())
    content[400] ^= 0xFF
    path.write_bytes(content)
    with pytest.raises(InvalidInput, match="'mug' is broken"):
        load_scene(path)
    path.write_bytes(content[:-30])
    with pytest.raises(InvalidInput, match="broken"):
        load_scene(path)


def test_a_zip_of_other_things_and_a_name_given_twice_are_refused(tmp_path):
    path = tmp_path / "scene.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "hello")
    with pytest.raises(InvalidInput, match=r"readme\.txt"):
        load_scene(path)
    np.save(tmp_path / "mug.npy", BOX)
    with zipfile.ZipFile(path, "w") as archive, pytest.warns(UserWarning, match="Duplicate"):
        archive.write(tmp_path / "mug.npy", "mug.npy")
        archive.write(tmp_path / "mug.npy", "mug.npy")
    with pytest.raises(InvalidInput, match="'mug' occurs twice"):
        load_scene(path)


def test_a_missing_path_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match="the path of the scene is empty"):
        load_scene("")
    with pytest.raises(InvalidInput, match="cannot be read: File name too long"):
        load_scene(tmp_path / ("a" * 300))
    with pytest.raises(InvalidInput, match="no such file or folder"):
        load_scene(tmp_path / "nothing.npz")


def test_matter_is_no_object(tmp_path):
    np.savez(tmp_path / "scene.npz", mug=BOX, matter=0.5 + BOX)
    scene = load_scene(tmp_path / "scene.npz")
    assert scene.names == ("mug",) and np.array_equal(scene.matter, 0.5 + BOX)
    np.savez(tmp_path / "scene.npz", mug=BOX, matter=np.zeros((3, 2)))
    with pytest.raises(InvalidInput, match=r"scene\.npz: matter .*\(3, 2\)"):
        load_scene(tmp_path / "scene.npz")


def test_masked_points_are_not_taken_for_points():
    masked = np.ma.masked_array(BOX, mask=np.zeros(BOX.shape, dtype=bool))
    assert Scene({"a": masked}).names == ("a",)
    masked[3] = np.ma.masked
    with pytest.raises(InvalidInput, match="masked entries"):
        Scene({"a": masked})


def test_a_table_under_objects_far_from_each_other_has_a_bounded_number_of_points(tmp_path):
    path = _save(tmp_path, a=BOX, b=BOX + np.array([9e7, 2e7, 0.0]), table_plane=[0.0, 0.0, 1.0, 0.0])
    tracemalloc.start()
    try:
        with pytest.raises(InvalidInput, match="extends over"):
            load_scene(path)
        assert tracemalloc.get_traced_memory()[1] < 50e6
    finally:
        tracemalloc.stop()
