"""The whole sequence before anything moves: order, grasps, placements and motions, step by step."""

from collections.abc import Callable, Collection, Iterable, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import Any

import numpy as np

from topple.planner.budget import within_budget
from topple.planner.decide.goal import Goal
from topple.planner.errors import NoSafePlan
from topple.planner.fallbacks import RELAXATIONS, select
from topple.planner.grasp.given import OwnGrasps, own_grasps
from topple.planner.placement.away import Away, Destination
from topple.planner.placement.base import choose_base
from topple.planner.planning.builder import PlanBuilder, Progress, check_relations
from topple.planner.planning.next_step import GoalTask
from topple.planner.planning.order import check_clamped, check_known, check_masks, ordered
from topple.planner.planning.plan_format import Plan
from topple.planner.planning.start import check_start
from topple.planner.planning.step import Context, NextStep, Orderer, Task
from topple.planner.planning.tolerances import TRIES
from topple.planner.verify.claims import SEEN_ORDER
from topple.robots.arm.arm import Arm, Station
from topple.robots.catalog import robot as robot_named
from topple.robots.catalog.own_arm import check_tool
from topple.robots.engines import BULLET, INSTALLED
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.workers import all_of
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.relations.relate import Relations
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.statics.gravity import check_up

UNPROVEN = "placements were not let go in simulation: no engine is installed"
REFUTED = "does not hold its own check"
UNCHECKED = "the plan was not checked by other means: PyBullet is not installed"


@checked_arguments
@within_budget
def plan(
    scene: AnyScene,
    goal: str | Collection[str] | Task,
    robot: Arm | str,
    *,
    pose_base_to_world: FloatArray | None = None,
    q_start: FloatArray | None = None,
    upright: Collection[str] = (),
    clamped: Collection[str] | str = (),
    grasps: OwnGrasps | None = None,
    orderer: Orderer = ordered,
    relations: Relations | Callable[[Scene], Relations] | None = None,
    away: str | Sequence[str | float] | Destination = Away.TABLE,
    allow_drop: bool = False,
    relaxations: Collection[str] = RELAXATIONS,
    verify: bool = False,
    budget: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Plan:
    """Plan everything that reaches a goal.

    Objects are taken in the safe order of `topple.planner.order`; of those that nothing has to precede, the
    first the arm can take goes, and the scene as it then should be is planned on. An object is put only where
    it stays by itself: every placement is tried in simulation, as `Plan.verify` will.

    Args:
        scene: What is seen, with `up`.
        goal: In words ("free plate", "lemon within bowl", "red on green on blue", "empty bowl", "sort"),
            names of objects to free, or any other task.
        robot: The arm, or its name.
        pose_base_to_world: (4, 4) where the arm stands; the scene's `robot_base`, or else searched for.
        q_start: (n,) joint values to start from [rad]; the arm's home where not given.
        upright: Objects that are kept upright while they are carried, with what is in them.
        clamped: Objects that a fixture, such as a vice, keeps where they stand until the hand holds them.
        grasps: Grasps of your own, in the scene's frame, as `rank_grasps` gives them or by object. An object
            that has any is taken by those alone, wherever it has been put by then, those with the highest
            scores that have room first; for the others grasps are searched for.
        orderer: What says in which order to free targets: see `topple.planner.planning.step.Orderer`.
        relations: Relations of your own, for the first step. Afterwards those of what was moved are worked
            out from its cloud; a function of the scene is asked before each step.
        away: Where things go that are taken: "table", to free places on what is seen; "lift", "bin", or
            ("zone", ...), ("hand-over", ...) with numbers, as `topple.planner.placement.away` has them.
        allow_drop: Whether an object may be released where no stable place is in reach; its step says so.
        relaxations: Names in `topple.planner.fallbacks` of what may be tried where the plain way fails.
        verify: Whether `Plan.verify` is asked before the plan is returned, which doubles the time. From a
            step that it refutes on is planned anew, with another grasp or place, three times at most. An
            order or relations of your own are not held against the dependencies that topple finds.
        budget: Wall-clock seconds for the whole call: what takes longer fails.
        seed: Of every search.
        progress: Called with a line for each step.

    Returns:
        The plan.

    Raises:
        NoSafePlan: There is none; the certificate has the cycle, or for each object why it cannot be moved,
            or what the check refutes.
        InvalidInput: The goal is none or hangs on a wrong mask, the scene does not know up or hangs in the
            air with it, the arm has no tool, or the grasps, the relations or what the orderer says do not
            fit the scene or the arm.
        OutOfBudget: The budget ran out.

    Examples:
        >>> plan(scene, "free cup", "panda").order
        ['cup']
    """
    arm = robot_named(robot) if isinstance(robot, str) else robot
    check_tool(arm)
    task, scene = GoalTask.of(goal), as_scene(scene)
    scene = scene if pose_base_to_world is None else scene.with_base(pose_base_to_world)
    wanted = task.goal(scene)
    scene = check_masks(scene, wanted.names)
    asked = None if relations is None or isinstance(relations, Relations) else relations
    first = check_relations(asked(scene) if asked else relations, scene)  # type: ignore
    situation = Situation.of(scene, first)
    check_up(situation.sized.scene, situation.sized.statics)
    given = scene.robot_base
    pose = choose_base(situation, arm) if given is None else given
    start = np.asarray(arm.home if q_start is None else q_start, dtype=np.float64)
    check_start(situation, arm, pose, start)
    context = Context(
        Station(arm, pose, start), allow_drop=allow_drop, orderer=orderer, seed=seed,
        upright=check_known(upright, scene, scene.names), clamped=check_clamped(scene, clamped),
        relaxations=select(relaxations), grasps={} if grasps is None else own_grasps(grasps, scene, arm),
    )  # fmt: skip
    planning = PlanBuilder(situation.with_level_undersides(), wanted, context, progress)
    planning.send_away(Destination.of(away))
    missing = [UNPROVEN] * (not INSTALLED) + [UNCHECKED] * (verify and BULLET not in INSTALLED)
    assumed = (*scene.assumptions, *arm.assumptions, *wanted.assumptions, *missing)

    def attempt() -> Plan:
        planning.run(task, asked)
        return planning.plan(given is None, assumed)

    own = () if orderer is ordered and relations is None else SEEN_ORDER.names
    return _check(attempt, planning, scene, own) if verify and BULLET in INSTALLED else _in_order(attempt())


@checked_arguments
def plan_all(
    scenes: Iterable[AnyScene],
    goal: str | Collection[str] | Task,
    robot: Arm | str,
    *,
    executor: Executor | None = None,
    **options: Any,
) -> list[Plan | NoSafePlan]:
    """Plan in many scenes, on the workers of an executor where one is given.

    Args:
        scenes: Scenes, or paths of their files: the workers then read these, and clouds do not travel.
        goal: As for `plan`, the same in every scene.
        robot: The arm, or its name.
        executor: Any executor of `concurrent.futures`, or that of a dask client; a worker that is lost costs
            its scene a second try.
        **options: As for `plan`; they pickle.

    Returns:
        The plan for each scene, or why there is none.

    Raises:
        InvalidInput: As `plan` and `load_scene`.
        WorkerLost: The worker of a scene was lost twice.

    Examples:
        >>> [made.order for made in plan_all([scene], "free cup", "panda")]
        [['cup']]
    """
    return list(all_of(partial(_plan_of, goal, robot, options), scenes, executor))


def _plan_of(
    goal: str | Collection[str] | Task, robot: Arm | str, options: dict[str, Any], source: AnyScene
) -> Plan | NoSafePlan:
    try:
        return plan(source, goal, robot, **options)
    except NoSafePlan as error:
        return error


def _in_order(found: Plan) -> Plan:
    """A plan that keeps its own dependencies: what hold each other break one, whichever goes first.

    Raises:
        NoSafePlan: It breaks one.
    """
    taken = [
        (name, index)
        for index, step in enumerate(found.steps)
        for name in (step.object, *(held.object for held in step.attachments))
    ]
    first, last = dict(reversed(taken)), dict(taken)
    broken = [
        f"{edge.then} would go before {edge.first}: hold the one while the other goes, with a second hand or "
        f"a fixture, clamped=[{edge.then!r}]"
        for edge in found.dependencies
        if edge.then in last and first.get(edge.first, len(found.steps)) > last[edge.then]
    ]
    if broken:
        raise NoSafePlan(f"the plan that was found {REFUTED}: {broken[0]}", tuple(broken))
    return found


def _check(attempt: Callable[[], Plan], planning: PlanBuilder, scene: Scene, own: Collection[str]) -> Plan:
    """A plan that holds its check; from a step that the check refutes on it is planned anew.

    Args:
        attempt: Plans on from where the builder is.
        planning: The builder.
        scene: What is planned in.
        own: Residuals that are the caller's own matter.

    Raises:
        NoSafePlan: There is no plan, or none that holds.
    """
    lines = tuple[str, ...]()
    for _ in range(TRIES):
        try:
            found = attempt()
        except NoSafePlan as error:
            words = f"{error}; another way {REFUTED}: {lines[0]}" if lines else str(error)
            raise NoSafePlan(words, (*error.certificate, *lines), error.failures) from error
        if planning.progress is not None:
            planning.progress(f"checking the plan by other means (steps: {len(found.steps)})")
        checked = found.verify(scene, planning.context.station.arm)
        failed = [each for each in checked.failed if each.name not in own]
        if not failed:
            return found
        lines = tuple(f"{each.name}: {each.value:.3g} {each.unit}, {each.witness}" for each in failed)
        steps = [step for each in failed for step in each.steps]
        if not steps:
            break
        planning.undo(min(steps))
    raise NoSafePlan(f"the plan that was found {REFUTED}: {lines[0]}", lines)


def plan_as_done(
    scene: Scene,
    goal: Goal,
    context: Context,
    steps: Sequence[NextStep],
) -> Plan:
    """The plan a closed loop followed: each step planned from a look of its own.

    Args:
        scene: What was seen at the start.
        goal: What was wanted.
        context: What the first step was chosen in, with the arm as it stood before each.
        steps: What was chosen and done, in order.

    Returns:
        The plan; an assumption says that the arm goes home between the steps.
    """
    planning = PlanBuilder(Situation(scene).with_level_undersides(), goal, context)
    for chosen in steps:
        planning.take(chosen)
    note = "each step was planned from a look of its own; between steps the arm goes home"
    return planning.plan(False, (*scene.assumptions, *context.station.arm.assumptions, note))
