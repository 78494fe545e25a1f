"""Every public name has an example that runs as it stands."""

import doctest
import inspect

import numpy as np
import pytest

import topple
import topple.planner
import topple.robots
import topple.topology

PACKAGES = (topple.topology, topple.robots, topple.planner, topple)
PUBLIC = {name: getattr(package, name) for package in PACKAGES for name in package.__all__}
del PUBLIC["__version__"]
SLOW = ("ClosedLoop", "MergedViews", "demo", "merge_views", "plan_page", "run")  # seconds in simulation


def on_a_box(centre, size, seed):
    """Points on the surface of an axis-aligned box [m]."""
    rng = np.random.default_rng(seed)
    points, side = rng.uniform(-0.5, 0.5, (3000, 3)), rng.integers(0, 3, 3000)
    points[np.arange(3000), side] = np.sign(points[np.arange(3000), side]) * 0.5
    return points * size + centre


def surroundings():
    """What examples are given: a cup on a book on a table, depth and mask of a block, corners of a box."""
    table = np.random.default_rng(9).uniform((0.2, -0.4, 0), (0.9, 0.4, 0), (20_000, 3))
    cup, book = (
        on_a_box((0.5, 0, 0.08), (0.06, 0.06, 0.08), 2),
        on_a_box((0.5, 0, 0.02), (0.2, 0.15, 0.04), 1),
    )
    depth, mask = np.full((60, 80), 0.8), np.zeros((60, 80), dtype=np.int64)
    depth[20:40, 30:50], mask[20:40, 30:50] = 0.7, 1
    clouds = {"table": table, "book": book, "cup": cup}
    return {
        **PUBLIC,
        "np": np,
        "scene": topple.Scene(clouds, fixed=["table"], up=[0, 0, 1], robot_base=np.eye(4)),
        "depth": depth,
        "mask": mask,
        "K": np.array([[70.0, 0, 39.5], [0, 70.0, 29.5], [0, 0, 1]]),
        "corners": np.array([[x, y, z] for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)]),
    }


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in sorted(PUBLIC)]
)
def test_the_example_of_each_public_name_is_true(name, tmp_path, monkeypatch):
    example = doctest.DocTestParser().get_examples(inspect.getdoc(PUBLIC[name]) or "")
    assert example, f"{name} has no example"
    if any("mujoco" in line.source for line in example):
        pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)
    test = doctest.DocTest(example, surroundings(), name, None, None, None)
    said = []
    assert doctest.DocTestRunner().run(test, out=said.append).failed == 0, "".join(said)
