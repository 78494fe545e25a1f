"""Broken files are read rightly or refused in a line; a reader that does neither is found."""

import logging
import subprocess
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from topple.benchmarks.fuzz import READERS, Reader, fuzz
from topple.benchmarks.fuzz.counting import changed, tried
from topple.benchmarks.fuzz.reader import KINDS
from topple.topology import InvalidInput, Scene, load_scene

INPUTS = 1000
BY_NAME = {reader.name: reader for reader in READERS}


@pytest.mark.parametrize("name", BY_NAME)
def test_the_sound_input_is_read(name, tmp_path):
    reader = BY_NAME[name]
    path = reader.write(reader.parts(), tmp_path)
    assert reader.wrong(reader.read(path), path) is None


@pytest.mark.parametrize("name", BY_NAME)
def test_no_reader_breaks(name):
    found = fuzz(BY_NAME[name], INPUTS // len(READERS))
    assert (found.reader, found.examples) == (name, ())
    assert found.clean == found.inputs == INPUTS // len(READERS)


def test_an_input_is_the_same_whatever_comes_before():
    reader = BY_NAME["pcd ascii"]
    sound = reader.parts()
    assert changed(reader, sound, 7, 3) == changed(reader, sound, 7, 3) != changed(reader, sound, 8, 3)
    assert sum(changed(reader, sound, number, 0) != sound for number in range(50)) > 45


def test_much_of_what_is_broken_is_refused_and_some_is_read(tmp_path):
    reader = BY_NAME["npz of clouds"]
    refused = 0
    for number in range(100):
        path = reader.write(changed(reader, reader.parts(), number, 0), tmp_path)
        try:
            reader.read(path)
        except InvalidInput:
            refused += 1
    assert 20 < refused < 95


def nan(path: Path) -> Scene:
    scene = load_scene(path)
    points = np.array(scene.clouds["mug"])
    points[0] = np.nan
    unchecked = object.__new__(Scene)
    unchecked.__dict__.update({**scene.__dict__, "clouds": {**scene.clouds, "mug": points}})
    return unchecked


def fewer(path: Path) -> Scene:
    scene = load_scene(path)
    return scene.with_cloud("mug", scene.clouds["mug"][:-1])


def other_points(path: Path) -> Scene:
    scene = load_scene(path)
    return scene.with_cloud("mug", scene.clouds["mug"] + 0.001)


def key_error(path: Path) -> Scene:
    raise KeyError(path.name)


def warning(path: Path) -> Scene:
    warnings.warn("something may be wrong", RuntimeWarning, stacklevel=1)
    return load_scene(path)


def logged(path: Path) -> Scene:
    logging.getLogger("somebody").error("Traceback (most recent call last)")
    return load_scene(path)


class Lines(InvalidInput):
    def __str__(self) -> str:
        return "two\nlines"


def two_lines(path: Path) -> Scene:
    raise Lines


def endless(path: Path) -> Scene:
    while True:
        try:
            sum(range(1000))
        except Exception:  # as readers do that take whatever goes wrong for a broken file
            pass


def starter(path: Path) -> Scene:
    subprocess.run(["true"], check=True)
    return load_scene(path)


SABOTAGES: dict[str, tuple[Callable[[Path], Scene], str, str]] = {
    "nan": (nan, "npz of clouds", "'mug' is not finite"),
    "fewer points than declared": (fewer, "pcd binary", "declares 24 points, and 23 came"),
    "fewer points of a ply": (fewer, "ply ascii", "declares 24 points, and 23 came"),
    "other points": (other_points, "npz of clouds", "other points than the file"),
    "a raw error": (key_error, "obj", "KeyError"),
    "a warning": (warning, "pcd ascii", "RuntimeWarning: something may be wrong"),
    "a trace in the log": (logged, "pcd ascii", "logged 'Traceback"),
    "a program that is started": (starter, "pcd ascii", "started true"),
    "two lines": (two_lines, "pcd ascii", "no line"),
}


@pytest.mark.parametrize("name", SABOTAGES)
def test_a_sabotaged_reader_is_found_broken(name, tmp_path):
    read, kind, words = SABOTAGES[name]
    reader = replace(BY_NAME[kind], read=read)
    said = tried(reader, reader.parts(), tmp_path)
    assert said is not None and words in said
    count = fuzz(reader, 30)
    assert count.broken > 0 and count.clean + count.broken == count.inputs == 30
    assert 1 <= len(count.examples) <= 3


def test_a_reader_that_does_not_end_is_ended(monkeypatch, tmp_path):
    monkeypatch.setattr("topple.benchmarks.fuzz.counting.SECONDS", 0.2)
    reader = replace(BY_NAME["pcd ascii"], read=endless)
    said = tried(reader, reader.parts(), tmp_path)
    assert said is not None and "not done after 0.4 s" in said


def test_what_takes_too_much_memory_is_found(monkeypatch, tmp_path):
    monkeypatch.setattr("topple.benchmarks.fuzz.counting.MEGABYTES", 50.0)

    def greedy(path: Path) -> Scene:
        np.ones(1 << 26).sum()  # half a gigabyte
        return load_scene(path)

    reader = replace(BY_NAME["pcd ascii"], read=greedy)
    said = tried(reader, reader.parts(), tmp_path)
    assert said is not None and said.endswith("MB")


@pytest.mark.parametrize("kind", KINDS)
def test_a_reader_that_takes_whatever_stands_where_a_file_should_is_found(kind, monkeypatch, tmp_path):
    monkeypatch.setattr("topple.benchmarks.fuzz.counting.SECONDS", 0.1)

    def credulous(path: Path) -> None:
        with (path / "mug.xyz").open("rb") as file:
            all(iter(lambda: file.read(1 << 16), b""))  # nothing is kept of a device that never ends

    reader = BY_NAME["xyz"]
    assert tried(reader, reader.parts(), tmp_path, kind) is None
    said = tried(replace(reader, read=credulous), reader.parts(), tmp_path, kind)
    assert said is not None and {"link": "opened", "folder": "IsADirectory"}.get(kind, "not done") in said


def test_every_reader_has_a_name_of_its_own():
    assert len(BY_NAME) == len(READERS)
    assert all(isinstance(reader, Reader) for reader in READERS)
