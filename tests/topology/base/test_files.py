"""Output files are written whole or not at all."""

import os
from pathlib import Path

import pytest

from topple.topology.base import files
from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import check_writable, write_all, write_whole


def test_text_and_bytes_are_written_and_nothing_else_is_left(tmp_path):
    assert write_whole(tmp_path / "a.txt", "Löffel").read_bytes() == "Löffel".encode()
    assert write_whole(tmp_path / "b.bin", b"\x00\x01").read_bytes() == b"\x00\x01"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.txt", "b.bin"]


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    target = write_whole(tmp_path / "a.txt", "old")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", full)
    with pytest.raises(InvalidInput, match=r"a\.txt: cannot be written, No space left"):
        write_whole(target, "new")
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_permissions_are_those_of_the_old_file_or_of_a_new_one(tmp_path):
    plain = tmp_path / "plain"
    plain.write_text("")
    assert write_whole(tmp_path / "new", "x").stat().st_mode == plain.stat().st_mode
    plain.chmod(0o640)
    assert write_whole(plain, "x").stat().st_mode & 0o777 == 0o640


def test_a_link_keeps_pointing_and_a_device_is_written_as_it_is(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_whole(tmp_path / "link", "x")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text() == "x"
    write_whole("/dev/null", "x")
    assert not Path("/dev/null").is_file()


def test_paths_that_cannot_be_written_are_refused(tmp_path):
    with pytest.raises(InvalidInput, match="is a folder"):
        check_writable(tmp_path)
    with pytest.raises(InvalidInput, match="does not exist"):
        check_writable(tmp_path / "no" / "a.txt")
    (tmp_path / "locked").mkdir(mode=0o500)
    if os.access(tmp_path / "locked", os.W_OK):
        pytest.skip("the superuser may write everywhere")
    with pytest.raises(InvalidInput, match="permission denied"):
        check_writable(tmp_path / "locked" / "a.txt")


def test_of_a_set_all_are_written_or_none(tmp_path):
    write_whole(tmp_path / "a.txt", "old")
    (tmp_path / "folder").mkdir()
    for bad in (tmp_path / "folder", Path("/dev/full"), tmp_path / "nowhere" / "b.txt"):
        with pytest.raises(InvalidInput, match="cannot be written"):
            write_all({tmp_path / "a.txt": "new", tmp_path / "c.txt": "new", bad: "new"})
        assert (tmp_path / "a.txt").read_text() == "old"
        assert sorted(path.name for path in tmp_path.iterdir()) == ["a.txt", "folder"]
    write_all({tmp_path / "a.txt": "new", tmp_path / "c.txt": b"new"})
    assert [(tmp_path / name).read_text() for name in ("a.txt", "c.txt")] == ["new", "new"]


def test_where_files_need_a_name_at_once_they_are_written_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(files.os, "O_TMPFILE", os.O_CREAT | os.O_EXCL | os.O_DIRECTORY)  # refused, as by NFS
    write_whole(tmp_path / "a.txt", "new")
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "new"
