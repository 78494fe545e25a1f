"""Tasks of others: guided-tamp-benchmark's shelf (Zorina et al., ICRA 2023), from a table into and onto it.

`--data DIR` is its unpacked wheel (guided-tamp-benchmark 0.1.0, PyPI): three demonstrations of one to three
YCB objects beside a table and a shelf, and ten places where a Panda may stand, some of them too near. The
videos guide nothing here: topple is given how things stand at first and at last. Furniture is as its
descriptions have it, legs left out; the arm begins at its home.
"""

import pickle
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import share
from topple.planner.errors import NoSafePlan
from topple.planner.planning.plan import plan
from topple.planner.rearranging.arrangement import Arrangement
from topple.planner.rearranging.task import ArrangementTask
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.samples import sample
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

TOP = ((-0.01, 0.0, -0.0125), (0.40, 1.20, 0.025))
CLOSED = ((0.0, 0.0, -0.6625), (0.38, 1.20, 1.28))
OPEN = (
    ((0.0, 0.0, -0.8275), (0.38, 1.20, 0.945)), ((0.1825, 0.0, -0.19), (0.015, 1.20, 0.33)),
    *(((-0.0075, y, -0.19), (0.365, 0.02, 0.33)) for y in (-0.59, 0.0, 0.59)),
)  # fmt: skip
"""Centres and sizes of the shelf's boards [m]."""

BOARD, SPACING, POINTS = 0.03, 0.008, 4000
"""[m] of the table's top, [m] between points of furniture, and points on an object."""


def rows(quick: bool, seed: int, progress: Progress, data: Path | None = None) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: The first two places of the arm alone.
        seed: Of the points on objects.
        progress: Called before each plan.
        data: The unpacked wheel.

    Raises:
        InvalidInput: There is no task in it.
    """
    tasks = sorted(data.glob("**/tasks/data/shelf_?.pkl")) if data is not None else []
    if not tasks:
        raise InvalidInput("tamp needs --data DIR: the unpacked wheel of guided-tamp-benchmark")
    seconds, wrong, near = list[float](), list[str](), 0
    for task in tasks:
        with task.open("rb") as file, task.with_name(f"{task.stem}_panda_poses.pkl").open("rb") as places:
            made, bases = _Arrays(file).load(), _Arrays(places).load()
        for number, base in list(bases.items())[1 : 3 if quick else None]:  # the first stands nowhere
            progress(f"{task.stem}, place {number}")
            scene, goal = _scenes(made, base, task.parents[2], seed)
            begun = process_time()
            try:
                if not plan(scene, ArrangementTask(Arrangement(goal)), robot="panda").verify(scene).ok:
                    wrong.append(f"{task.stem}, place {number}: does not verify")
            except InvalidInput as error:
                if "the start is in collision" not in str(error):
                    raise
                near += 1
                continue
            except NoSafePlan as error:
                wrong.append(f"{task.stem}, place {number}: {error}")
            seconds.append(process_time() - begun)
    tried = len(seconds)
    found = [
        share("plans that verify", tried - len(wrong), tried, counted=True, wrong=wrong),
        Row("left out, as the arm stands in the shelf, the table or a thing", near, ""),
        Row("CPU of a plan and its check, median", float(np.median(seconds)), "s"),
    ]
    return [row.to_json() for row in found]


class _Arrays(pickle.Unpickler):
    """Loads NumPy's arrays and plain values, and calls nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        if module.split(".")[0] != "numpy" or name not in ("_reconstruct", "ndarray", "dtype"):
            raise InvalidInput(f"a file of a task names {module}.{name}: expected arrays alone")
        return super().find_class(module, name)


def _scenes(made: dict[str, Any], base: FloatArray, folder: Path, seed: int) -> tuple[Scene, Situation]:
    """How things stand at first, and at last."""
    import trimesh

    clouds: dict[str, FloatArray] = {}
    furniture = zip(made["furniture_ids"], made["furniture_poses"], made["furniture_params"], strict=True)
    for name, pose, given in furniture:
        clouds[name] = move_points(sample(list(_boards(given)), SPACING), pose)
    for name, pose in zip(made["object_ids"], made["q_start"], strict=True):
        mesh: Any = trimesh.load_mesh(folder / f"models/data/ycbv/meshes/obj_0000{name[-2:]}.obj")
        points = trimesh.sample.sample_surface(mesh, POINTS, seed=seed)[0]
        clouds[name] = move_points(np.asarray(points) / 1000, pose)  # its meshes are in millimetres
    scene = Scene(clouds, fixed=made["furniture_ids"], up=(0, 0, 1), robot_base=base)
    goal = Situation(scene)
    for name, here, there in zip(made["object_ids"], made["q_start"], made["q_goal"], strict=True):
        goal = goal.moved((name,), there @ np.linalg.inv(here))
    return scene, goal


def _boards(given: dict[str, Any]) -> Iterator[FloatArray]:
    """(8, 3) corners of each board of a table or a shelf [m]."""
    if "desk_size" in given:
        boards = [((0.0, 0.0, -BOARD / 2.0), (*given["desk_size"][:2], BOARD))]
    else:
        boards = [TOP, *(OPEN if given["display_inside_shelf"] else (CLOSED,))]
    signs = np.array(np.meshgrid((-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5))).reshape(3, -1).T
    for centre, size in boards:
        yield np.array(centre) + signs * np.array(size)
