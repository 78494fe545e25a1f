"""`--masks-as-they-are`: without it what hangs on a mask on nothing is refused."""

from pathlib import Path

import numpy as np
import pytest

from topple.planner.cli.main import main
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.camera import Camera
from topple.robots.world.world import World

GHOST = 90
BASE = ["--base", "-0.5", "0", "0", "0"]


@pytest.fixture(scope="module")
def frame(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A block on a table, and a mask beside it where there is nothing."""
    with World() as world:
        world.add_table(size=(1.4, 1.4))
        world.add(shapes.block("block"), pose_at(0, 0, 0), fixed=True)
        seen = Camera.looking_at((0.4, 0.1, 0.5), (0, 0, 0)).look(world, np.random.default_rng(0))
    rows, columns = np.indices(seen.label.shape)
    middle = np.argwhere(seen.label == next(k for k, name in seen.names.items() if name == "block")).mean(
        axis=0
    )
    label = seen.label.copy()
    label[np.hypot(rows - middle[0], columns - middle[1] - 70) < 14] = GHOST
    ids, names = zip(*{**seen.names, GHOST: "ghost"}.items(), strict=True)
    path = tmp_path_factory.mktemp("frame") / "frame.npz"
    np.savez(
        path, depth=seen.depth, K=seen.K, label=label, ids=np.array(ids), names=np.array(names),
        pose_camera_to_world=seen.pose_camera_to_world,
    )  # fmt: skip
    return str(path)


@pytest.fixture
def grasps(tmp_path: Path) -> str:
    """A pose over the ghost."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    np.save(tmp_path / "poses.npy", pose[None])
    return str(tmp_path / "poses.npy")


def refused(argv: list[str], capsys: pytest.CaptureFixture[str]) -> bool:
    code = main([*argv, "--fixed", "table"])
    said = capsys.readouterr().err
    if code == 2:
        assert "the mask of 'ghost' is level with what carries it" in said
        assert "--masks-as-they-are" in said
        assert said.strip().count("\n") == 0
    return code == 2


@pytest.mark.parametrize("orderer", [[], ["--orderer", "cautious"]])
def test_order(frame, orderer, capsys):
    assert refused(["order", frame, *orderer, "--target", "ghost"], capsys)
    assert not refused(["order", frame, *orderer, "--target", "ghost", "--masks-as-they-are"], capsys)
    assert not refused(["order", frame, *orderer, "--target", "block"], capsys)
    assert not refused(["order", frame, *orderer], capsys)


def test_the_order_says_it_all_the_same(frame, typed):
    for more in ([], ["--masks-as-they-are"]):
        assert "the mask of 'ghost' is level" in typed("order", frame, "--fixed", "table", *more).out


def test_rank(frame, grasps, capsys):
    assert refused(["rank", frame, grasps, "--target", "ghost"], capsys)
    assert not refused(["rank", frame, grasps, "--target", "ghost", "--masks-as-they-are"], capsys)
    assert not refused(["rank", frame, grasps], capsys)


def test_plan(frame, capsys):
    assert refused(["plan", frame, "--target", "ghost", *BASE], capsys)
    assert not refused(["plan", frame, "--target", "ghost", *BASE, "--masks-as-they-are"], capsys)
    assert not refused(["plan", frame, "--target", "block", *BASE], capsys)


def test_run(frame, capsys):
    assert refused(["run", frame, "--target", "ghost", *BASE], capsys)


@pytest.mark.slow
def test_run_goes_on_with_masks_as_they_are(frame, capsys):
    assert not refused(["run", frame, "--target", "ghost", *BASE, "--masks-as-they-are"], capsys)
