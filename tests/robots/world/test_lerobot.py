"""Demonstrations are read back by the layout that LeRobot documents for its datasets of version 3."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from topple.planner.execution.trial import Trial
from topple.robots.catalog import robot
from topple.robots.world.camera import Camera
from topple.robots.world.film import RATE, SIZE
from topple.robots.world.lerobot import VIDEO, Demonstration
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.base.errors import InvalidInput

av = pytest.importorskip("av", reason="demonstrations need PyAV: pip install '.[lerobot]'")
parquet = pytest.importorskip("pyarrow.parquet", reason="needs pyarrow: pip install '.[lerobot]'")

CAMERA = Camera.looking_at((1.2, 0.6, 0.9), (0.2, 0.0, 0.2))


class Dataset:
    """A dataset, by its description alone: paths by its templates, places by its episodes."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.info = json.loads((folder / "meta/info.json").read_text())
        self.stats = json.loads((folder / "meta/stats.json").read_text())
        files = sorted((folder / "meta/episodes").glob("*/*.parquet"))
        self.episodes = [row for file in files for row in parquet.read_table(file).to_pylist()]
        tasks = parquet.read_table(folder / "meta/tasks.parquet")
        self.tasks = dict(zip(*(tasks[key].to_pylist() for key in ("task_index", "task")), strict=True))

    def rows(self, number: int) -> dict[str, np.ndarray]:
        at = {key: self.episodes[number][f"data/{key}"] for key in ("chunk_index", "file_index")}
        table = parquet.read_table(self.folder / self.info["data_path"].format(**at)).to_pydict()
        mine = np.array(table["episode_index"]) == number
        return {key: np.array(values)[mine] for key, values in table.items()}

    def frames(self, number: int) -> list[tuple[float, np.ndarray]]:
        one = self.episodes[number]
        at = {key: one[f"videos/{VIDEO}/{key}"] for key in ("chunk_index", "file_index")}
        begin, end = (one[f"videos/{VIDEO}/{key}_timestamp"] for key in ("from", "to"))
        with av.open(str(self.folder / self.info["video_path"].format(video_key=VIDEO, **at))) as film:
            shown = [(float(f.time), f.to_ndarray(format="rgb24")) for f in film.decode(video=0)]
        return [(time - begin, picture) for time, picture in shown if begin <= time < end - 1e-6]


@contextmanager
def standing(name: str = "panda") -> Iterator[SimulatedArm]:
    """An arm at a table."""
    with World() as world:
        world.add_table()
        yield SimulatedArm(world, robot(name), np.eye(4))


def record(folder: Path, task: str, turn: float, success: bool = True) -> None:
    with standing() as arm, Demonstration(folder, arm, CAMERA) as shown:
        arm.wait(0.1)
        arm.q_target = np.add(arm.q_target, [turn, 0, 0, 0, 0, 0, 0])
        arm.wait(0.2)
        if success and turn > 0.2:
            arm.close(10.0)
        shown.end(task, success)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    folder = tmp_path_factory.mktemp("demonstrations") / "data"
    record(folder, "free plate", 0.3)
    record(folder, "free can", -0.2, success=False)
    record(folder, "free plate", 0.1)
    return Dataset(folder)


def test_the_description_is_that_of_version_3(dataset):
    info = dataset.info
    assert (info["codebase_version"], info["fps"], info["robot_type"]) == ("v3.0", RATE, "panda")
    assert info["total_episodes"] == len(dataset.episodes) == 3 and info["splits"] == {"train": "0:3"}
    assert info["total_frames"] == sum(one["length"] for one in dataset.episodes)
    assert dataset.tasks == {0: "free plate", 1: "free can"} and info["total_tasks"] == 2
    assert [one["tasks"] for one in dataset.episodes] == [["free plate"], ["free can"], ["free plate"]]
    starts = [one["dataset_from_index"] for one in dataset.episodes]
    assert starts[1:] == [one["dataset_to_index"] for one in dataset.episodes[:-1]] and starts[0] == 0


def test_rows_have_the_features_that_are_described(dataset):
    for number, one in enumerate(dataset.episodes):
        rows, count = dataset.rows(number), one["length"]
        assert set(rows) == set(dataset.info["features"]) - {VIDEO}
        for key, values in rows.items():
            shape = dataset.info["features"][key]["shape"]
            assert values.shape == ((count,) if shape == [1] else (count, *shape)), key
        assert rows["index"].tolist() == list(range(one["dataset_from_index"], one["dataset_to_index"]))
        assert np.allclose(rows["timestamp"], np.arange(count) / RATE, atol=1e-6)
        assert rows["next.done"].tolist() == [False] * (count - 1) + [True]
        assert rows["next.success"].any() == (number != 1)
        assert {dataset.tasks[k] for k in rows["task_index"]} == set(one["tasks"])


def test_states_are_measured_and_actions_are_told(dataset):
    rows, names = dataset.rows(0), dataset.info["features"]["action"]["names"]
    assert names[-2:] == ["panda_finger_joint1", "panda_finger_joint2"]
    turned = np.flatnonzero(np.diff(rows["action"][:, 0]) > 0.2)
    assert len(turned) == 1
    assert rows["observation.state"][-1, 0] == pytest.approx(rows["action"][-1, 0], abs=0.01)
    assert rows["action"][0, -1] > 0.03 and rows["action"][-1, -1] == 0.0, "the hand was told to close"


def test_every_row_has_its_picture(dataset):
    for number, one in enumerate(dataset.episodes):
        frames = dataset.frames(number)
        assert len(frames) == one["length"]
        assert np.allclose([time for time, _ in frames], dataset.rows(number)["timestamp"], atol=1e-4)
        assert frames[0][1].shape == (SIZE[1], SIZE[0], 3) == tuple(dataset.info["features"][VIDEO]["shape"])


def test_statistics_are_those_of_all_episodes(dataset):
    every = np.concatenate([dataset.rows(number)["action"] for number in range(3)])
    found = dataset.stats["action"]
    for key, expected in (("mean", every.mean(0)), ("std", every.std(0)), ("max", every.max(0))):
        assert np.allclose(found[key], expected, atol=1e-6), key
    assert found["count"] == [len(every)]
    mean = np.array(dataset.stats[VIDEO]["mean"])
    assert mean.shape == (3, 1, 1) and 0.0 < mean.mean() < 1.0


def test_pandas_finds_tasks_by_their_words(dataset):
    told = json.loads(parquet.read_schema(dataset.folder / "meta/tasks.parquet").metadata[b"pandas"])
    assert told["index_columns"] == ["task"]
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    assert pandas.read_parquet(dataset.folder / "meta/tasks.parquet").loc["free can"].task_index == 1


def test_nothing_is_written_of_what_did_not_end(dataset):
    before = sorted(dataset.folder.rglob("*.*"))
    with standing() as arm, pytest.raises(KeyboardInterrupt), Demonstration(dataset.folder, arm, CAMERA):
        raise KeyboardInterrupt
    assert sorted(dataset.folder.rglob("*.*")) == before


def test_other_joints_and_other_folders_are_refused(dataset, tmp_path):
    (tmp_path / "letter.txt").write_text("dear")
    for folder, said in ((dataset.folder, "other features"), (tmp_path, "is no dataset of LeRobot")):
        with standing("xarm6") as arm, pytest.raises(InvalidInput, match=said):
            Demonstration(folder, arm, CAMERA)


@pytest.mark.slow
def test_a_run_becomes_an_episode(tmp_path, typed):
    scene: Any = Trial(0.05, (0.5, 0.0, 0.0)).scene()
    np.savez(tmp_path / "scene.npz", **scene.clouds, fixed=["table"], up=[0, 0, 1], robot_base=np.eye(4))
    command = ["run", str(tmp_path / "scene.npz"), "block", "--robot", "panda-suction"]
    assert f"Written: {tmp_path / 'data'}" in typed(*command, "--lerobot", tmp_path / "data").out
    dataset = Dataset(tmp_path / "data")
    assert dataset.tasks == {0: "free block"} and dataset.info["features"]["action"]["names"][-1] == "vacuum"
    rows = dataset.rows(0)
    assert rows["next.success"][-1] and {0.0, 1.0} == set(rows["action"][:, -1].tolist())
    assert len(dataset.frames(0)) == dataset.episodes[0]["length"] > 5 * RATE
    assert "is no dataset of LeRobot" in typed(*command, "--lerobot", tmp_path, code=2).err
