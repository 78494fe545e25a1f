"""Whole plans, made and checked: ten objects cleared by a Panda, towers, full bowls and dishes.

The ten are blocks, cans, boxes and fruit dropped into a loose pile, seen by three depth cameras. A plan
counts where every motion is certified and `Plan.verify` finds every residual at most 0; the scenes are the
built-in ones, seen once from the start. Times are of one process on this machine, looking not included.
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import share
from topple.planner.errors import NoSafePlan
from topple.planner.execution.demo import task_in
from topple.planner.execution.look import Observer
from topple.planner.planning.plan import plan
from topple.planner.planning.step import Task
from topple.robots import shapes
from topple.robots.catalog import robot as robot_named
from topple.robots.scenarios.scenario import Scenario, Unlucky, drop, settle, settled
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import in_bullet
from topple.topology.base.errors import ToppleError
from topple.topology.base.workers import Lost, map_tasks, open_executor
from topple.topology.scene.scene import Scene

REARRANGED: tuple[str, ...] = ("set-table", "restack", "pack", "swap")
"""Scenes in which things are put as they lie in another one."""

MANY = 40
"""Seeds of each scene in which one arrangement is turned into another; the first is the bench's."""

VERIFIED = 95.0
"""[%] of them that are to be planned whole and verified."""

COUNT = 10
SECONDS = 15.0
SEEDS = 10
KINDS: dict[str, str] = {
    "tower": "three blocks stacked",
    "lemon": "a lemon into an occupied bowl",
    "dishes": "a plate freed of dishes",
}
Maker = Callable[[str, np.random.Generator], Body]
MAKERS: tuple[Maker, ...] = (
    lambda name, rng: shapes.block(name, float(rng.uniform(0.035, 0.055))),
    lambda name, rng: shapes.can(name, diameter=float(rng.uniform(0.05, 0.068)), height=0.09),
    lambda name, rng: shapes.box(
        name, (float(rng.uniform(0.09, 0.13)), 0.06, float(rng.uniform(0.03, 0.05)))
    ),
    lambda name, rng: shapes.lemon(name),
)
"""Things that a hand of 8 cm takes: what is measured is planning, not what a hand cannot do."""


def rows(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: One tower; piles of ten and the other kinds take minutes.
        seed: First seed of the scenes.
        progress: Called before each plan.

    Returns:
        The bench's rows.
    """
    found = [] if quick else _clearing(range(seed, seed + 3), progress)
    count = 1 if quick else SEEDS
    for kind, words in list(KINDS.items())[: 1 if quick else len(KINDS)]:
        held = 0
        for one in range(seed, seed + count):
            progress(f"{kind}, seed {one}: planning and verifying")
            held += _holds(kind, one)
        what = f"{words}: plans that verify with every residual <= 0, of {count}"
        found.append(Row(what, float(held), "plans", bar=f">= {count}").to_json())
    return found


def rearranged(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    """Count how many arrangements are turned into others by one whole plan that verifies.

    Args:
        quick: One seed of the last scene.
        seed: First seed of the scenes.
        progress: Called as plans end.

    Returns:
        The bench's rows.
    """
    scenes = REARRANGED[-1:] if quick else REARRANGED
    numbers = range(seed, seed + (1 if quick else MANY))
    held = dict.fromkeys(scenes, 0)
    wanted = [(scene, one) for one in numbers for scene in scenes]
    with open_executor(None) as pool:
        for answer in map_tasks(_rearranged, wanted, pool, in_turn=False):
            if isinstance(answer, Lost):
                raise ToppleError(f"the plan of {answer.task} was lost with the process that made it")
            scene, one, verified = answer
            held[scene] += verified
            progress(f"{scene}, seed {one}: {'verified' if verified else 'no plan that verifies'}")
    of, bar, what = len(numbers), f">= {VERIFIED:g}", "planned whole from one look, and verified"
    found = [share(f"{scene}: {what}, of {of}", count, of, bar) for scene, count in held.items()]
    return [row.to_json() for row in found]


def _rearranged(wanted: tuple[str, int]) -> tuple[str, int, bool]:
    """A scene's name and seed, and whether the plan made of one look at it verifies."""
    from topple.robots import scenario

    name, seed = wanted
    with scenario(name, seed) as stage:
        return name, seed, _verifies(stage, seen(stage), task_in(stage, stage.cameras, seed))


def _clearing(seeds: range, progress: Progress) -> list[dict[str, Any]]:
    """The longest of the times that plans of ten objects take, and how many were found and certified."""
    longest, proven = 0.0, 0
    for seed in seeds:
        progress(f"ten objects, seed {seed}: planning")
        with ten(seed) as stage:
            scene = seen(stage)
        begun = time.perf_counter()
        try:
            base = stage.pose_base_to_world
            made = plan(scene, list(scene.movable), stage.robot, pose_base_to_world=base, seed=seed)
            proven += made.certified
        except NoSafePlan:
            pass  # counted below
        longest = max(longest, time.perf_counter() - begun)
    what, of = f"{COUNT}-object clear-all with a Panda", len(seeds)
    return [
        Row(f"{what}: plan, slowest of {of}", longest, "s", bar=f"<= {SECONDS:g}").to_json(),
        Row(f"{what}: found and certified, of {of}", float(proven), "plans", bar=f">= {of}").to_json(),
    ]


def _holds(kind: str, seed: int) -> bool:
    from topple.robots import scenario

    with scenario(kind, seed) as stage:
        return _verifies(stage, seen(stage), stage.goal)


def _verifies(stage: Scenario, scene: Scene, goal: str | Task) -> bool:
    """Whether there is a plan from what was seen, and it passes its check."""
    try:
        made = plan(scene, goal, stage.robot, pose_base_to_world=stage.pose_base_to_world, seed=stage.seed)
    except NoSafePlan:
        return False
    return made.certified and made.verify(scene).ok


def seen(stage: Scenario) -> Scene:
    """What the cameras of a scene see of it, the arm standing in it.

    Args:
        stage: The settled scene.

    Returns:
        The clouds.
    """
    SimulatedArm(in_bullet(stage.world), robot_named(stage.robot), stage.pose_base_to_world)
    rng = np.random.default_rng(stage.seed)
    return Observer(stage.world, stage.cameras, rng, stage.fixed, stage.up).look().scene


def ten(seed: int) -> Scenario:
    """Ten things in a loose pile, to be cleared by a Panda.

    Args:
        seed: Any number.

    Returns:
        The settled scene.
    """
    return settled("ten", seed, _pile, robot="panda")


def _pile(world: PhysicalWorld, rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
    names: list[str] = []
    for index in range(COUNT):
        body = MAKERS[int(rng.integers(len(MAKERS)))](f"thing {index}", rng)
        x, y = rng.uniform([-0.13, -0.2], [0.15, 0.2]).tolist()
        drop(world, body, x, y, Rotation.from_euler("z", rng.uniform(0, 2 * np.pi)))
        settle(world, 3.0)
        names.append(body.name)
    for name in names:
        if np.linalg.norm(world.pose(name)[:2, 3]) > 0.32:
            raise Unlucky(f"{name} rolled away")
    return "clear", tuple(names)
