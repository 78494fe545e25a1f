"""What is exported refuses what it cannot use in topple's words: every argument is given every wrong kind."""

import inspect
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import topple
import topple.planner
import topple.robots
import topple.topology
from topple.topology import DepthImage, InvalidInput, Mesh, Scene, ToppleError, scene_from_objects

CUBE = trimesh.creation.box((0.1, 0.1, 0.1))
SCENE = scene_from_objects(
    {"low": CUBE, "high": CUBE.copy().apply_translation((0, 0, 0.1))}, fixed=["low"], up=(0, 0, 1)
)
K = np.array([[5.0, 0.0, 3.0], [0.0, 5.0, 2.0], [0.0, 0.0, 1.0]])

WRONG: dict[str, Any] = {
    "none": None,
    "number": 7,
    "negative": -1,
    "fraction": 0.5,
    "NaN": float("nan"),
    "numpy's number": np.float32(3),
    "bool": True,
    "text": "nobody",
    "empty text": "",
    "empty list": [],
    "numbers": [1, 2],
    "names": ["low", "nobody"],
    "dict": {"nobody": 1},
    "set": {"nobody"},
    "tuple": (None,),
    "row": np.zeros(5),
    "image": np.zeros((4, 6)),
    "no pose": np.full((4, 4), np.nan),
    "objects": np.array([object()]),
    "mesh": CUBE,
    "meshes": trimesh.Scene(CUBE),
    "own mesh": Mesh(CUBE.vertices, CUBE.faces),
    "path": Path("nowhere"),
    "scene": SCENE,
    "function": len,
    "object": object(),
}
RIGHT: dict[str, Any] = {
    "scene": SCENE,
    "start": SCENE,
    "scenes": [SCENE],
    "goal": "free nobody",  # refused after all other arguments: nothing is planned or played
    "name": "nobody",
    "robot": "panda",
    "images": [],
    "objects": {"cube": CUBE},
    "points": CUBE.vertices,
    "vertices": CUBE.vertices,
    "faces": CUBE.faces,
    "clouds": {"cube": CUBE.vertices},
    "depth": np.ones((4, 6)),
    "label": np.ones((4, 6), dtype=int),
    "masks": np.ones((4, 6), dtype=int),
    "K": K,
    "annotations": [],
    "path": "nowhere.npz",
    "folder": "nowhere",
    "spacing": 0.01,
    "matrix": np.ones((2, 3)),
    "grasps": np.eye(4)[None],
    "array": np.eye(4)[None],
    "pose_base_to_world": np.eye(4),
    "pose_second_to_world": np.eye(4),
    "client": 0,
}
EXPORTED = {
    name: getattr(package, name)
    for package in (topple, topple.topology, topple.robots, topple.planner)
    for name in package.__all__
}
CALLED = {
    name: each
    for name, each in sorted(EXPORTED.items())
    if callable(each) and not (isinstance(each, type) and issubclass(each, (Exception, Enum)))
}


def misuses(function: Any) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """For each argument and wrong kind both names, and all arguments of a call, the others right."""
    parameters = inspect.signature(function).parameters.values()
    named = [each for each in parameters if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)]
    needed = [each.name for each in named if each.default is each.empty or each.name in ("goal", "name")]
    for parameter in named:
        for kind, value in WRONG.items():
            yield parameter.name, kind, {**{name: RIGHT.get(name) for name in needed}, parameter.name: value}


@pytest.mark.parametrize("name", CALLED)
def test_wrong_kinds_are_used_or_refused_and_nothing_raw_comes_out(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # some are names of files to be written
    raw: list[str] = []
    for argument, kind, given in misuses(CALLED[name]):
        try:
            CALLED[name](**given)
        except ToppleError as error:
            assert len(str(error).splitlines()) == 1
        except Exception as error:
            raw.append(f"{argument} = {kind}: {type(error).__name__}: {error}")
    assert not raw


def test_hundreds_of_misuses_are_generated():
    assert sum(1 for function in CALLED.values() for _ in misuses(function)) > 5000


@pytest.mark.parametrize(
    ("name", "given", "told"),
    [
        (
            "run",
            {"scene": 5},
            r"^scene is 5: expected Scene \| str \| PathLike\[str\] \(clouds and meshes make",
        ),
        ("order", {"targets": [7]}, r"^targets\[0\] is 7: expected str$"),
        ("order", {"hands": True}, r"^hands is True: expected int \| None$"),
        ("plan", {"pose_base_to_world": "here"}, r"^pose_base_to_world holds text, expected real numbers$"),
        ("merge_views", {"images": ["a.npz"]}, r"^images\[0\] is 'a.npz': expected DepthImage$"),
        ("DepthImage", {"names": ["cup"]}, r"^names is of <class 'list'>: expected Mapping\[int, str\]$"),
    ],
)
def test_what_is_wrong_is_said_with_what_is_expected(name, given, told):
    function = CALLED[name]
    needed = [
        each.name for each in inspect.signature(function).parameters.values() if each.default is each.empty
    ]
    with pytest.raises(InvalidInput, match=told):
        function(**{**{each: RIGHT[each] for each in needed}, **given})


def test_pictures_are_no_names_of_files():
    with pytest.raises(InvalidInput, match=r"^images\[0\] is 'a.npz': expected DepthImage$"):
        Scene.from_images(["a.npz"])  # type: ignore[list-item]


def test_what_numpy_and_people_write_arrives_as_annotated():
    image = DepthImage(np.ones((4, 6)), K.tolist(), np.ones((4, 6)), names={np.int64(1): "cup"})  # type: ignore[arg-type]
    assert image.names == {1: "cup"}
    found = topple.order(SCENE, {"high"}, seed=np.int64(3), hands=np.int64(1))  # type: ignore[arg-type]
    assert found.order == ("high",)


@pytest.mark.parametrize(
    "name", ["build_order", "dependencies", "next_view", "order", "relate", "rearrange", "run"]
)
def test_a_path_is_taken_wherever_a_scene_is(name):
    goal = {"goal": "low on high"} if name in ("run", "rearrange") else {}
    with pytest.raises(InvalidInput, match=r"^nowhere\.npz: no such file"):
        CALLED[name]("nowhere.npz", **goal)
