"""What an arm did as a demonstration to learn from: a dataset of LeRobot v3, an episode for each run.

Layout: https://huggingface.co/docs/lerobot/lerobot-dataset-v3. Each episode has files of its own, so that a
run is added to a dataset by writing beside what is there.
"""

import json
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.camera import Camera
from topple.robots.world.film import RATE, SIZE, Film, encoder
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, NotInstalled
from topple.topology.base.files import make_folder, write_all
from topple.topology.io.strict_json import read_json

VERSION = "v3.0"
VIDEO = "observation.images.front"
_PLACE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
_DATA, _EPISODES = f"data/{_PLACE}.parquet", f"meta/episodes/{_PLACE}.parquet"
_TASKS, _INFO = "meta/tasks.parquet", "meta/info.json"
_VIDEOS = f"videos/{{video_key}}/{_PLACE}.mp4"
_JOINTS = ("observation.state", "action")
_KINDS = ("data", "meta/episodes", f"videos/{VIDEO}")  # of files of an episode
_COUNTERS = {name: "int64" for name in ("frame_index", "episode_index", "index", "task_index")}
_SCALARS = {"timestamp": "float32", "next.done": "bool", "next.success": "bool", **_COUNTERS}
_TASK = {"name": "task", "field_name": "task", "pandas_type": "unicode", "numpy_type": "object"}
_BY_TASK = {"index_columns": ["task"], "column_indexes": [], "columns": [_TASK], "pandas_version": "2.0.0"}

Stats = dict[str, dict[str, Any]]


class Demonstration:
    """Records an episode from when it is entered until it is left; it is written if `end` was called.

    Each picture has a row: `observation.state`, the measured joints of arm and hand and, with a cup, whether
    it holds; `action`, what the same are told to be.

    Args:
        folder: The dataset; made where there is none.
        robot: The arm.
        camera: Where from; only its place and direction count.

    Raises:
        InvalidInput: What is in the folder is no such dataset, or of other joints.
        NotInstalled: pyarrow or PyAV is missing.
    """

    def __init__(self, folder: Path, robot: ActingArm, camera: Camera) -> None:
        check_dataset(folder)
        self._folder, self._robot = folder, robot
        self._names = [*robot.joint_names, *(["vacuum"] if robot.cup else [])]
        self._info = _info_at(folder) or _new_info(robot.arm.name, self._names)
        if self._info["features"] != _features(self._names) or self._info["fps"] != RATE:
            raise InvalidInput(f"{folder} is a dataset of other features: expected {', '.join(self._names)}")
        self._episode = int(self._info["total_episodes"])
        chunk, file = divmod(self._episode, self._info["chunks_size"])
        self._at = {"chunk_index": chunk, "file_index": file}
        video = folder / _VIDEOS.format(video_key=VIDEO, **self._at)
        make_folder(video.parent)
        self._video, self._film = video, Film(video, robot, camera, each=self._sample)
        self._seen = list[tuple[Any, Any, FloatArray]]()  # states, actions, pixels
        self._ended: tuple[str, bool] | None = None

    def __enter__(self) -> "Demonstration":
        """Begin the episode."""
        self._film.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        """Write the episode, or nothing where its end was not told."""
        self._film.__exit__()
        if self._ended is None:
            self._video.unlink()
        else:
            self._write(*self._ended)

    def end(self, task: str, success: bool) -> None:
        """Say what the episode was for, in words, and whether it was reached."""
        self._ended = task, success

    def _sample(self, picture: Any) -> None:
        robot, cup = self._robot, self._robot.cup is not None
        state = [*robot.joint_positions(robot.joint_names), *[float(robot.sealed or 0)] * cup]
        action = [*robot.joint_targets, *[float(robot.vacuum is not None)] * cup]
        self._seen.append((state, action, picture[::8, ::8].reshape(-1, 3) / 255))

    def _write(self, task: str, success: bool) -> None:
        states, actions, pixels = (np.array(each, np.float32) for each in zip(*self._seen, strict=True))
        count, first, at = len(states), int(self._info["total_frames"]), self._at
        steps, tasks = np.arange(count), _tasks_of(self._folder)
        rows: dict[str, Any] = {
            "observation.state": states, "action": actions, "timestamp": np.float32(steps / RATE),
            "next.done": steps == count - 1, "next.success": (steps == count - 1) & success,
            "frame_index": steps, "episode_index": np.full(count, self._episode), "index": first + steps,
            "task_index": np.full(count, tasks.setdefault(task, len(tasks))),
        }  # fmt: skip
        stats = {name: _stats(values.reshape(count, -1)) for name, values in rows.items()}
        stats[VIDEO] = _stats(pixels.reshape(-1, 3), (-1, 1, 1))
        episode: dict[str, Any] = {
            "episode_index": self._episode, "tasks": [task], "length": count,
            "dataset_from_index": first, "dataset_to_index": first + count,
            **{f"{kind}/{key}": at[key] for kind in _KINDS for key in at},
            f"videos/{VIDEO}/from_timestamp": 0.0, f"videos/{VIDEO}/to_timestamp": count / RATE,
            **{f"stats/{name}/{key}": value for name, one in stats.items() for key, value in one.items()},
        }  # fmt: skip
        self._info |= {
            "total_episodes": self._episode + 1, "total_frames": first + count, "total_tasks": len(tasks),
            "splits": {"train": f"0:{self._episode + 1}"},
        }  # fmt: skip
        known = self._folder / "meta/stats.json"
        contents: dict[Path, str | bytes] = {
            self._folder / _DATA.format(**at): _parquet(rows),
            self._folder / _EPISODES.format(**at): _parquet({key: [value] for key, value in episode.items()}),
            self._folder / _TASKS: _parquet({"task_index": [*tasks.values()], "task": [*tasks]}),
            known: json.dumps(_merge(read_json(known.read_bytes(), "") if first else {}, stats)),
            self._folder / _INFO: json.dumps(self._info, indent=1),
        }
        for path in contents:
            make_folder(path.parent)
        write_all({**contents})


def _parquet(columns: Mapping[str, Any]) -> bytes:
    """A table as a file: rows (n, k) as lists, tasks as the index by which LeRobot looks for them."""
    import pyarrow
    from pyarrow import parquet

    lists = pyarrow.FixedSizeListArray.from_arrays
    rows = {key: lists(np.ravel(columns[key]), len(columns[key][0])) for key in _JOINTS if key in columns}
    table = pyarrow.table({**columns, **rows})
    if "task" in columns:
        table = table.replace_schema_metadata({"pandas": json.dumps(_BY_TASK)})
    parquet.write_table(table, sink := pyarrow.BufferOutputStream())
    return sink.getvalue().to_pybytes()


def _tasks_of(folder: Path) -> dict[str, int]:
    """Number of each task of a dataset."""
    from pyarrow import parquet

    place = folder / _TASKS
    known = parquet.read_table(place).to_pydict() if place.exists() else {"task": [], "task_index": []}
    return dict(zip(known["task"], known["task_index"], strict=True))


def check_dataset(folder: Path) -> None:
    """Refuse a folder that no demonstration can be written to.

    Raises:
        InvalidInput: There is something else in it.
        NotInstalled: pyarrow or PyAV is missing.
    """
    if find_spec("pyarrow") is None:
        raise NotInstalled("demonstrations need pyarrow and PyAV", "lerobot")
    encoder()
    if _info_at(folder) is None and folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InvalidInput(f"{folder} is no dataset of LeRobot {VERSION}: give a new folder, or one of such")


def demonstration_in(
    folder: Path | None, robot: ActingArm, camera: Camera
) -> AbstractContextManager[Demonstration | None]:
    """A demonstration, or nothing where no folder is given."""
    return nullcontext() if folder is None else Demonstration(folder, robot, camera)


def _info_at(folder: Path) -> dict[str, Any] | None:
    """The description of the dataset in a folder; None where there is none of this version."""
    place = folder / _INFO
    if not place.is_file():
        return None
    told = read_json(place.read_bytes(), str(place))
    return told if isinstance(told, dict) and told.get("codebase_version") == VERSION else None


def _new_info(robot: str, names: list[str]) -> dict[str, Any]:
    return {
        "codebase_version": VERSION, "robot_type": robot, "total_episodes": 0, "total_frames": 0,
        "total_tasks": 0, "splits": {}, "fps": RATE, "chunks_size": 1000, "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 500, "data_path": _DATA, "video_path": _VIDEOS,
        "features": _features(names),
    }  # fmt: skip


def _features(names: list[str]) -> dict[str, Any]:
    width, height = SIZE
    shown = {
        "video.height": height, "video.width": width, "video.channels": 3, "video.fps": RATE,
        "video.codec": "h264", "video.pix_fmt": "yuv420p", "is_depth_map": False, "has_audio": False,
    }  # fmt: skip
    joints = {"dtype": "float32", "shape": [len(names)], "names": names}
    video = {"dtype": "video", "shape": [height, width, 3], "names": ["height", "width", "channels"]}
    scalars = {name: {"dtype": kind, "shape": [1], "names": None} for name, kind in _SCALARS.items()}
    return {**dict.fromkeys(_JOINTS, joints), VIDEO: {**video, "info": shown}, **scalars}


def _stats(values: Any, shape: tuple[int, ...] = (-1,)) -> dict[str, Any]:
    """Statistics of values (n, k) for LeRobot to normalise by: least, largest, mean, deviation of each."""
    found = {key: getattr(values.astype(float), key)(axis=0) for key in ("min", "max", "mean", "std")}
    return {**{key: each.reshape(shape).tolist() for key, each in found.items()}, "count": [len(values)]}


def _merge(before: Stats, now: Stats) -> Stats:
    """Statistics of two sets of episodes together."""
    found = dict(now)
    for name in before:
        a, b = ({key: np.array(value) for key, value in each[name].items()} for each in (before, now))
        share = a["count"] / (a["count"] + b["count"])
        mean = share * a["mean"] + (1.0 - share) * b["mean"]
        spread = [each["std"] ** 2 + (each["mean"] - mean) ** 2 for each in (a, b)]
        one = {
            "min": np.minimum(a["min"], b["min"]), "max": np.maximum(a["max"], b["max"]), "mean": mean,
            "std": np.sqrt(share * spread[0] + (1.0 - share) * spread[1]), "count": a["count"] + b["count"],
        }  # fmt: skip
        found[name] = {key: value.tolist() for key, value in one.items()}
    return found
