"""MotionBenchMaker's problems: read from its archive, counted unless their ends touch by the exact meshes."""

import io
import shutil
import tarfile

import numpy as np
import pytest
import trimesh
import yaml

from topple.benchmarks.mbm import _peer_rows, rows
from topple.benchmarks.motion_problems import Problem, Solid, box, checker_of
from topple.benchmarks.peers import Answer
from topple.robots import robot
from topple.topology.base.errors import InvalidInput

JOINTS = [f"panda_joint{k}" for k in range(1, 8)]
FREE, AWAY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], [1.2, -0.6, 0.0, -2.2, 0.0, 1.571, 0.785]


def problem(centre: list[float]) -> dict[str, object]:
    """A scene with one box, and the way from one state past it to another."""
    place = {"position": centre, "orientation": [0, 0, 0, 1]}
    shape = {"type": "box", "dimensions": [0.2, 0.2, 0.2]}
    box = {"id": "box", "primitives": [shape], "primitive_poses": [place]}
    wanted = [{"joint_name": name, "position": value} for name, value in zip(JOINTS, AWAY, strict=True)]
    return {
        "scene": {"world": {"collision_objects": [box]}},
        "request": {
            "start_state": {"joint_state": {"name": JOINTS, "position": FREE}},
            "goal_constraints": [{"joint_constraints": wanted}],
        },
    }


def test_what_has_a_free_goal_is_solved_and_what_touches_is_left_out(tmp_path):
    folder = tmp_path / "resources/panda"
    shutil.copytree(robot("panda").model.path.parent, folder)
    with tarfile.open(folder / "problems.tar.bz2", "w:bz2") as archive:
        for number, centre in enumerate(([0.6, 0.6, 0.1], [0.0, 0.0, 0.4])):  # beside the way, and in the arm
            for part, content in problem(centre).items():
                data = yaml.safe_dump(content).encode()
                member = tarfile.TarInfo(f"problems/box_panda/{part}{number:04d}.yaml")
                member.size = len(data)
                archive.addfile(member, io.BytesIO(data))
    solved, touching, median, *_ = rows(False, 0, lambda text: None, tmp_path)
    assert (solved["tried"], solved["held"], touching["value"]) == (1, 1, 1)
    assert median["value"] > 0


def test_a_path_of_a_peer_that_touches_is_told_and_one_that_does_not_solve_is_no_path():
    arm, boxes = robot("panda"), {"box": box((0.3, 0.2, 0.4), (0.1, 0.1, 0.8))}
    problem = Problem(boxes, checker_of(arm, boxes), np.array(FREE), np.array([AWAY]))
    through, stays = np.array([FREE, AWAY]), np.array([FREE, FREE])
    found = _peer_rows("a peer", [problem] * 3, [Answer(0.1, q) for q in (through, stays, None)])
    assert [round(row.value) for row in found] == [67, 50, 100, 100, 100]


def test_without_an_archive_it_says_what_it_needs(tmp_path):
    with pytest.raises(InvalidInput, match="mbm needs --data DIR"):
        rows(False, 0, lambda text: None, tmp_path)


@pytest.mark.parametrize(
    ("kind", "sizes", "shape"),
    [
        ("box", [0.3, 0.2, 0.4], trimesh.creation.box([0.3, 0.2, 0.4])),
        ("sphere", [0.1], trimesh.creation.icosphere(subdivisions=4, radius=0.1)),
        ("cylinder", [0.4, 0.08], trimesh.creation.cylinder(radius=0.08, height=0.4, sections=96)),
    ],
)
def test_a_primitive_lies_within_its_polyhedron_which_is_little_wider(kind, sizes, shape):
    part = Solid(kind, sizes, np.eye(4)).corners
    for direction in np.random.default_rng(0).normal(size=(200, 3)):
        direction /= np.linalg.norm(direction)
        assert -1e-6 < (part @ direction).max() - (np.asarray(shape.vertices) @ direction).max() < 0.004
