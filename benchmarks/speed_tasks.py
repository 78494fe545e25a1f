"""What the bench of speed times, one task a process: it runs with this tree or with an older one.

Usage: python speed_tasks.py TASK SETTINGS, with SETTINGS in JSON; prints what it took in JSON. Only calls and
arguments are used that older trees have as well; where a module has moved since, both places are tried.
"""

import inspect
import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

Settings = dict[str, Any]
MOTIONS = ("step", "wait", "follow", "follow_until", "open", "close", "extend", "suck", "release", "tare")
"""What an arm does, or waits for; the rest of a closed loop is thinking."""


def order_scenes(settings: Settings) -> list[float]:
    """CPU time of file to order [s] of each of some files; the first pays for imports."""
    order = getattr(import_module("topple.planner"), "order")  # noqa: B009
    return [_cpu(lambda path=path: order(_scene(path))) for path in settings["paths"]]


def order_process(settings: Settings) -> list[float]:
    """CPU time [s] of `topple order` of each file as a process of its own, the second of two."""
    command = [sys.executable, "-m", "topple.planner.cli.main", "order", "--json"]
    return [_of_process([*command, path, *_fixed(path)]) for path in settings["paths"]]


def imports(settings: Settings) -> list[float]:
    """CPU time [s] of a process that imports numpy and SciPy, the second of two."""
    return [_of_process([sys.executable, "-c", "import numpy, scipy.spatial, scipy.optimize"])]


def hulls(settings: Settings) -> list[float]:
    """CPU time [s] of Qhull on every cloud of each file, the median of five."""
    return [sorted(_cpu(partial(_hulls, _scene(path))) for _ in range(5))[2] for path in settings["paths"]]


def _hulls(scene: Any) -> None:
    from scipy.spatial import ConvexHull

    for cloud in scene.clouds.values():
        ConvexHull(cloud, qhull_options="Qt QJ")  # a table is flat


def order_again(settings: Settings) -> list[float]:
    """CPU time [s] of relations and order of each file once one object has moved by half a centimetre."""
    order = getattr(import_module("topple.planner"), "order")  # noqa: B009
    relate = getattr(import_module("topple.topology"), "relate")  # noqa: B009
    found: list[float] = []
    for path in settings["paths"]:
        scene = _scene(path)
        relations = relate(scene)
        order(scene, relations=relations)
        name = scene.movable[0]
        cloud = scene.clouds[name] + 0.005

        def again(
            scene: Any = scene, relations: Any = relations, name: str = name, cloud: Any = cloud
        ) -> None:
            order(scene.with_cloud(name, cloud), relations=relations.updated(name, cloud))

        found.append(_cpu(again))
    return found


def plan_scene(settings: Settings) -> list[float]:
    """CPU time of a plan that clears a scene [s]; an order made before, for the imports, does not count."""
    import numpy as np

    planner = import_module("topple.planner")
    (path,) = settings["paths"]
    scene = _scene(path)
    base = np.array(settings["base"])
    planner.order(scene)

    def again() -> None:
        named = "base" if "base" in inspect.signature(planner.plan).parameters else "pose_base_to_world"
        place: dict[str, Any] = {named: base}
        planner.plan(_scene(path), list(scene.movable), "panda", seed=0, **place)

    return [_cpu(again)]


def think(settings: Settings) -> list[float]:
    """CPU and wall time [s] of thinking for each action of a built-in scene, and the actions."""
    loop_in = _of("loop_in", "topple.planner.execution.demo", "topple.planner.demo")
    scenario = _scenario()
    acting = _Acting(
        _of("SimulatedArm", "topple.robots.world.simulated_arm", "topple.robots.simulated_arm"),
        _of("Camera", "topple.robots.world.camera", "topple.robots.camera"),
    )
    with scenario(settings["scene"], settings["seed"]) as stage:
        loop = loop_in(stage, seed=settings["seed"], cameras=3)
        acting.cpu = acting.wall = 0.0
        cpu, wall = time.process_time(), time.perf_counter()
        record = loop.run()
        cpu, wall = time.process_time() - cpu - acting.cpu, time.perf_counter() - wall - acting.wall
    actions = max(1, len(record.steps))
    return [cpu / actions, wall / actions, actions]


def wait(settings: Settings) -> list[float]:
    """Wall times [s] of a run in a built-in scene and of the waiting before each action but the first."""
    loop_in = _of("loop_in", "topple.planner.execution.demo", "topple.planner.demo")
    scenario = _scenario()
    with scenario(settings["scene"], settings["seed"]) as stage:
        record = loop_in(stage, seed=settings["seed"], ahead=settings["ahead"]).run()
    return [record.seconds, *(step.waited for step in record.steps[1:])]


def demo(settings: Settings) -> list[float]:
    """Wall time of `topple demo` [s], which writes into a folder."""
    command = [sys.executable, "-m", "topple.planner.cli.main", "demo", "--json"]
    begun = time.perf_counter()
    subprocess.run(command, cwd=settings["folder"], capture_output=True, check=True)
    return [time.perf_counter() - begun]


class _Acting:
    """The time that arms and cameras take: their methods are timed, the outermost calls alone."""

    def __init__(self, arm: type, camera: type) -> None:
        self.cpu = self.wall = 0.0
        self._deep = 0
        for name in MOTIONS:
            if hasattr(arm, name):
                setattr(arm, name, self._timed(getattr(arm, name)))
        setattr(camera, "look", self._timed(getattr(camera, "look")))  # noqa: B009, B010

    def _timed(self, method: Callable[..., Any]) -> Callable[..., Any]:
        def timed(*args: Any, **more: Any) -> Any:
            cpu, wall = time.process_time(), time.perf_counter()
            self._deep += 1
            try:
                return method(*args, **more)
            finally:
                self._deep -= 1
                if self._deep == 0:
                    self.cpu += time.process_time() - cpu
                    self.wall += time.perf_counter() - wall

        return timed


def _scene(path: str) -> Any:
    """A scene; the table of frames is the label 1 where no table is named."""
    load_scene = _of("load_scene", "topple.topology.io.load")
    from topple.topology import UnknownObject

    if path.endswith("_scene.npz"):
        return load_scene(Path(path))
    with suppress(UnknownObject):
        return load_scene(Path(path), fixed=["1"])
    return load_scene(Path(path))


def _fixed(path: str) -> list[str]:
    """How a command is told of the table of a frame."""
    return ["--fixed", "1"] if "1" in _scene(path).fixed else []


def _of_process(command: Sequence[str]) -> float:
    """CPU time [s] of a process and what it starts, the second of two that do the same."""
    taken = 0.0
    for _ in range(2):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, capture_output=True, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        taken = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return taken


def _of(name: str, *modules: str) -> Any:
    """What is called `name` in the first of some modules that there is."""
    for module in modules[:-1]:
        with suppress(ModuleNotFoundError):
            return getattr(import_module(module), name)
    return getattr(import_module(modules[-1]), name)


def _scenario() -> Any:
    """What makes a built-in scene: commits before called it otherwise."""
    known = (("topple.robots", "scenario"), ("topple.robots.scenarios", "scenario_called"))
    found = (getattr(import_module(module), name, None) for module, name in known)
    return next(filter(None, found))


def _cpu(call: Callable[[], object]) -> float:
    begun = time.process_time()
    call()
    return time.process_time() - begun


TASKS: dict[str, Callable[[Settings], list[float]]] = {
    "order": order_scenes,
    "process": order_process,
    "imports": imports,
    "hulls": hulls,
    "again": order_again,
    "plan": plan_scene,
    "think": think,
    "wait": wait,
    "demo": demo,
}


def main(arguments: Sequence[str]) -> None:
    """Do a task and print its figures.

    Args:
        arguments: The task's name and its settings in JSON.
    """
    name, settings = arguments
    print(json.dumps(TASKS[name](json.loads(settings))))  # noqa: T201


if __name__ == "__main__":
    main(sys.argv[1:])
