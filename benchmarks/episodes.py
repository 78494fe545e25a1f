"""Seeded runs of the built-in scenes and of real frames, and how they ended."""

import os
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.other_piles import NAME as OTHER_PILE
from topple.benchmarks.other_piles import other_pile
from topple.benchmarks.possible import freeing_order
from topple.benchmarks.rules import order_by
from topple.planner.decide.goal import parse_goal
from topple.planner.execution.attained import truly_unmet
from topple.planner.execution.demo import loop_in
from topple.planner.execution.judge import LIMITS
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.planning.order import cautious
from topple.robots import scenario
from topple.robots.engines import BULLET, new_world, playing_on
from topple.robots.scenarios import Scenario
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.world import in_bullet
from topple.topology.base.errors import InvalidInput, ToppleError

FORMAT, FORMAT_VERSION = "topple.episode", 1
"""Of the lines of a journal."""

TOPPLE = "topple"
"""The rule of an episode whose order topple decides."""

IDEAL = "any order, ideal lifts"
"""The rule of an episode that no arm plays: whether its target could be freed at all."""

LATER = frozenset({"robot", "engine", "ahead", "waited", "alone", "turned", "friction"})
"""Keys that journals of before do not have: all their episodes are of the scene's own arms on PyBullet, which
wait for each step to be chosen."""

MOST = 1e15
"""Below it lies every number of an ending: no seed, time or memory [bytes] comes to that."""

ENDINGS = (
    "success", "hit", "disturbed", "dropped", "no plan", "budget", "blind", "arm", "goal missed", "crash",
)  # fmt: skip
"""How an episode can end; of several that apply to one that failed, the first."""


@dataclass(frozen=True)
class Episode:
    """What is played.

    Attributes:
        scenario: One of `topple.robots.scenarios.SCENARIOS`, `OTHER_PILE`, or the name of a frame.
        seed: Of the scene, the sensor noise and every search.
        cameras: How many of the scene's cameras look.
        rule: What decides the order: `TOPPLE`, one of `topple.benchmarks.rules.RULES`, or `IDEAL`.
        folder: Where the frame is; empty for a built-in scene.
        mask_noise: Standard deviation in pixels by which edges of masks are wrong.
        shuffle_labels: Whether names of objects are not kept between looks.
        wrist_camera: Whether the arm carries one more camera for a second look.
        meshes: Folder of the models that an other pile is made of; empty for shapes by formula alone.
        robot: The arm; empty for the one that the scene is made for.
        engine: What it is played on, one of `topple.robots.engines.ENGINES`; scenes settle on PyBullet.
        ahead: Whether the next step is chosen while the arm acts.
        alone: Whether there is one arm, also where the scene is made for two.
        turned: Degrees from 0 by which everything is turned about the vertical, once it has settled.
        friction: What the coefficient of friction of each thing that moves is multiplied by then.
    """

    scenario: str
    seed: int
    cameras: int = 3
    rule: str = TOPPLE
    folder: str = ""
    mask_noise: float = 0.0
    shuffle_labels: bool = False
    wrist_camera: bool = False
    meshes: str = ""
    robot: str = ""
    engine: str = BULLET
    ahead: bool = False
    alone: bool = False
    turned: float = 0.0
    friction: float = 1.0

    @property
    def as_settled(self) -> bool:
        """Whether it is played in the world that the scene settled in."""
        return self.engine == BULLET and self.turned == 0.0 and self.friction == 1.0


@dataclass(frozen=True)
class Ending:
    """How an episode went.

    Attributes:
        episode: What was played.
        ending: One of `ENDINGS`.
        violations: What went wrong, a sentence each.
        violated: How many objects were hit, moved, tipped or dropped that should not have been.
        objects: Movable objects of the scene.
        placed: Objects that are where the goal wants them in the end.
        places: Objects the goal wants somewhere.
        steps: Actions done.
        seconds: Wall-clock time, everything included [s].
        robot_seconds: Simulated time the arm moved [s].
        memory: What the process holds afterwards [bytes].
        process: Which process played it: those of one number came one after the other.
        used: Largest share of a limit that something which was not handled came to: of what it may move, turn
            or be hit by; above 1 it was disturbed.
        sagged: How far the body that moved most got while a rebuilt world, or one on another engine than it
            settled on, came to rest [m]; None where it is neither.
        fallbacks: What was tried to find a step where the plain way failed, and whether that step succeeded.
        waited: How long the arm waited for each decision [s], wall-clock time.
    """

    episode: Episode
    ending: str
    violations: tuple[str, ...] = ()
    violated: int = 0
    objects: int = 0
    placed: int = 0
    places: int = 0
    steps: int = 0
    seconds: float = 0.0
    robot_seconds: float = 0.0
    memory: int = 0
    process: int = 0
    used: float = 0.0
    sagged: float | None = None
    fallbacks: tuple[tuple[str, bool], ...] = ()
    waited: tuple[float, ...] = ()

    @property
    def success(self) -> bool:
        """Whether the goal was reached without a violation."""
        return self.ending == "success"

    @property
    def clean(self) -> bool:
        """Whether nothing was hit, disturbed or dropped, reached or not."""
        return self.ending not in ("hit", "disturbed", "dropped", "crash")

    def to_json(self) -> dict[str, Any]:
        """The line of a journal."""
        return {"format": FORMAT, "format_version": FORMAT_VERSION, **asdict(self)}

    @staticmethod
    def from_json(entry: Mapping[str, Any]) -> "Ending":
        """Read a line of a journal.

        Args:
            entry: As `to_json` gives it; other keys are passed over.

        Returns:
            The ending.

        Raises:
            InvalidInput: A key is missing, or holds something else; the message has its path.
        """
        _check_keys(entry, Ending, "$")
        _check_keys(entry["episode"], Episode, "$.episode")
        try:
            ending = msgspec.convert(entry, Ending)
        except (msgspec.ValidationError, OverflowError) as error:
            raise InvalidInput(str(error)) from error
        for each, where in ((ending, "$"), (ending.episode, "$.episode")):
            for key, value in vars(each).items():
                if isinstance(value, (int, float)) and not 0 <= value < MOST:  # nan is neither
                    raise InvalidInput(f"{value!r:.20} is none of 0 to {MOST:g} - at `{where}.{key}`")
        if ending.placed > ending.places:
            raise InvalidInput(f"{ending.placed} of {ending.places} places - at `$.placed`")
        return ending

    def __str__(self) -> str:
        """A few words for a line of progress."""
        played = f"{self.episode.scenario} {self.episode.seed} by {self.episode.rule}"
        return f"{played}: {self.ending} after {self.seconds:.0f} s"


def _check_keys(entry: Any, kind: type[Episode] | type[Ending], where: str) -> None:
    """Refuse an entry that leaves keys out: defaults are for those who make one, not for those who read."""
    if not isinstance(entry, Mapping):
        raise InvalidInput(f"expected an object - at `{where}`")
    missing = [key for key in kind.__dataclass_fields__ if key not in entry and key not in LATER]
    if missing:
        raise InvalidInput(f"no {', '.join(missing)} - at `{where}`")


def play(episode: Episode) -> Ending:
    """Play an episode.

    Args:
        episode: What is played.

    Returns:
        How it went. An error of the program is an ending too, so that a bench goes on and counts it.
    """
    begun = time.perf_counter()
    try:
        return _played(episode, begun)
    except Exception as error:
        words = f"{type(error).__name__}: {error}"
        kind = "no plan" if isinstance(error, ToppleError) else "crash"
        return Ending(
            episode,
            kind,
            (words,),
            seconds=time.perf_counter() - begun,
            memory=_memory(),
            process=os.getpid(),
        )


def _played(episode: Episode, begun: float) -> Ending:
    if episode.folder:
        from topple.benchmarks.frames import act_out  # nothing of it is needed for built-in scenes

        record, sagged, movable = act_out(
            Path(episode.folder), episode.scenario, episode.seed, episode.cameras
        )
        return _ended(episode, record, begun, movable, sagged=sagged)
    with ExitStack() as stack:
        stage, sagged = stack.enter_context(_stage(episode)), None
        if not episode.as_settled:
            world = stack.enter_context(copied(stage.world, episode))
            after = stage.finished and stack.enter_context(copied(stage.finished, episode))
            stage, sagged = replace(stage, world=world, finished=after), _sagged(world)
        if episode.rule == IDEAL:
            return _possible(episode, stage, begun)
        base = stage.pose_base_to_world
        orderer = cautious if episode.rule == TOPPLE else order_by(episode.rule, base)
        loop = loop_in(
            stage, robot=episode.robot or None, seed=episode.seed, cameras=episode.cameras, orderer=orderer,
            mask_noise=episode.mask_noise, shuffle_labels=episode.shuffle_labels,
            wrist_camera=episode.wrist_camera, ahead=episode.ahead, alone=episode.alone,
        )  # fmt: skip
        first = loop.look()
        goal = parse_goal(stage.goal, first.scene)
        record = loop.run(first)
        missing = len(truly_unmet(goal, stage.world, stage.up))
        movable = len(stage.world.movable)
    places = len(goal.places)
    placed = max(places - missing, 0)
    return _ended(episode, record, begun, movable, placed=placed, places=places, sagged=sagged)


def _stage(episode: Episode) -> Scenario:
    if episode.scenario == OTHER_PILE:
        return other_pile(episode.seed, Path(episode.meshes) if episode.meshes else None)
    return scenario(episode.scenario, episode.seed)


def copied(world: PhysicalWorld, episode: Episode) -> PhysicalWorld:
    """The bodies of a world, on the engine of an episode, turned and as rough as it says.

    Args:
        world: Where they lie as they settled.
        episode: What is played.
    """
    with playing_on(episode.engine):
        copy = new_world()
    turn = pose_at(0.0, 0.0, 0.0, Rotation.from_euler("z", episode.turned, degrees=True))
    for name in world.names:
        body, fixed = world.body(name), name in world.fixed
        rough = body.friction * (1.0 if fixed else episode.friction)
        copy.add(replace(body, friction=rough), turn @ world.pose(name), fixed=fixed)
    return copy


def _sagged(world: PhysicalWorld) -> float:
    """Let a world come to rest; returns how far the body that moved most got [m]."""
    before = world.poses()
    world.settle()
    return max(float(np.linalg.norm((world.pose(name) - before[name])[:3, 3])) for name in world.movable)


def _possible(episode: Episode, stage: Scenario, begun: float) -> Ending:
    """Whether the true bodies could be lifted in any order that frees the target."""
    found = freeing_order(in_bullet(stage.world), stage.targets[0])
    return Ending(
        episode,
        "no plan" if found is None else "success",
        objects=len(stage.world.movable),
        steps=len(found or ()),
        seconds=time.perf_counter() - begun,
        memory=_memory(),
        process=os.getpid(),
    )


def _ended(
    episode: Episode,
    record: RunRecord,
    begun: float,
    movable: int,
    placed: int = 0,
    places: int = 0,
    sagged: float | None = None,
) -> Ending:
    return Ending(
        episode=episode,
        ending=_ending(record),
        violations=record.violations,
        violated=sum(_violated(step) for step in record.steps),
        objects=movable,
        placed=placed,
        places=places,
        steps=len(record.steps),
        seconds=time.perf_counter() - begun,
        robot_seconds=sum(step.robot_seconds or 0.0 for step in record.steps),
        memory=_memory(),
        process=os.getpid(),
        used=max((_used(step) for step in record.steps), default=0.0),
        sagged=sagged,
        fallbacks=tuple((name, step.success) for step in record.steps for name in step.fallbacks),
        waited=tuple(step.waited for step in record.steps if step.waited is not None),
    )


def _ending(record: RunRecord) -> str:
    """The worst that happened, as one of `ENDINGS`."""
    if record.success:
        return "success"
    if any(hit > LIMITS.hit for step in record.steps for hit in step.impulses.values()):
        return "hit"
    if any(_violated(step) for step in record.steps):
        return "disturbed"
    if any(step.dropped for step in record.steps):
        return "dropped"
    if record.stopped:
        return record.stopped
    return "goal missed"


def _violated(step: StepRecord) -> int:
    """Objects an action moved, tipped or hit though it was not about them."""
    moved = {
        name
        for name, (distance, angle) in step.disturbed.items()
        if distance > LIMITS.distance or angle > LIMITS.angle
    }
    hit = {name for name, impulse in step.impulses.items() if impulse > LIMITS.hit}
    return len(moved | hit)


def _used(step: StepRecord) -> float:
    """The largest share of a limit that an action came to at what it was not about."""
    moved = [d / LIMITS.distance for d, _ in step.disturbed.values()]
    turned = [a / LIMITS.angle for _, a in step.disturbed.values()]
    pressed = [impulse / LIMITS.hit for impulse in step.impulses.values()]
    return max([0.0, *moved, *turned, *pressed])


def _memory() -> int:
    """Memory this process holds [bytes]."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")
