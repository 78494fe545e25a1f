"""A list of meshes and poses as a scene."""

import json
from typing import Any

import numpy as np
import pytest

from topple.topology import InvalidInput, load_scene

POSE = np.array([[0.0, -1, 0, 0.3], [1, 0, 0, 0], [0, 0, 1, 0.2], [0, 0, 0, 1]])
TETRAHEDRON = "v 0 0 0\nv .1 0 0\nv 0 .2 0\nv 0 0 .3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


@pytest.mark.parametrize("wrapped", [False, True])
def test_meshes_stand_at_their_poses(wrapped, tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "part.obj").write_text(TETRAHEDRON)
    objects: list[dict[str, Any]] = [
        {"name": "a", "mesh": "meshes/part.obj", "pose": POSE.tolist()},
        {"name": "b", "mesh": "meshes/part.obj", "pose": np.eye(4).tolist()},
    ]
    told = {"objects": objects, "up": [0, 0, 1], "masses": {"a": 2.0}, "fixed": ["b"]} if wrapped else objects
    (tmp_path / "poses.json").write_text(json.dumps(told))
    scene = load_scene(tmp_path / "poses.json")
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3]])
    assert np.allclose(sorted(scene.meshes["b"].vertices.tolist()), sorted(corners.tolist()))
    assert np.allclose(scene.meshes["a"].vertices.max(axis=0), [0.3, 0.1, 0.5])
    assert scene.masses == ({"a": 2.0} if wrapped else {})
    assert scene.fixed == ({"b"} if wrapped else set())


@pytest.mark.parametrize(
    ("told", "says"),
    [
        ([], "lists no objects"),
        ({"mug": 1}, "lists no objects"),
        ([{"name": "a"}], "object 0 has no name or no mesh"),
        ([{"name": "a", "mesh": "a.obj"}], "pose of 'a'"),
        ([{"name": "a", "mesh": "../a.obj", "pose": np.eye(4).tolist()}], "not below the folder"),
        ([{"name": "a", "mesh": "a.obj", "pose": (2 * np.eye(4)).tolist()}], "pose of 'a'"),
        ([{"name": "a", "mesh": "a.obj", "pose": np.eye(4).tolist()}] * 2, "two objects are called 'a'"),
    ],
)
def test_what_is_no_list_of_poses_is_refused_in_one_line(told, says, tmp_path):
    (tmp_path / "a.obj").write_text(TETRAHEDRON)
    (tmp_path / "poses.json").write_text(json.dumps(told))
    with pytest.raises(InvalidInput, match=says):
        load_scene(tmp_path / "poses.json")
