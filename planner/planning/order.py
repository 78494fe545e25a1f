"""In which order to take things: the fewest removals that free the targets, and why."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from topple.planner.budget import within_budget
from topple.planner.building.apart import taking_apart
from topple.planner.decide.arrange import Order, arrange
from topple.planner.decide.assumptions import assumptions as assumed
from topple.planner.decide.beliefs import Beliefs
from topple.planner.decide.dependency import (
    DependencyGraph,
    dependencies,
    reason_out,
    with_fixture,
    with_measured,
)
from topple.planner.decide.names import SpokenNames
from topple.planner.planning.tolerances import REMOVAL_RISK, TOP
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import as_names
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.values import FrozenDict
from topple.topology.base.workers import all_of
from topple.topology.io.load import AnyScene
from topple.topology.situation.situation import Situation
from topple.topology.statics.gravity import check_up

if TYPE_CHECKING:
    from topple.robots.arm.arm import Arm
    from topple.topology.relations.relate import Relations
    from topple.topology.scene.scene import Scene
    from topple.topology.statics.rest import Statics


@checked_arguments
@within_budget
def order(
    scene: AnyScene | Situation,
    targets: Collection[str] | str | None = None,
    *,
    seed: int = 0,
    verify: bool = False,
    budget: float | None = None,
    robot: "Arm | str | None" = None,
    relations: "Relations | None" = None,
    removal_risk: float | None = None,
    beliefs: Beliefs | None = None,
    check_gravity: bool = True,
    hands: int | None = None,
    clamped: Collection[str] | str = (),
) -> Order:
    """Find the order that frees the targets with the fewest removals, or with the least risk.

    Args:
        scene: A scene that knows where up is, the path of one, or the situation it was read as.
        targets: Names to free; none clears everything.
        seed: Seed of the simulations, where there are any.
        verify: Check the dependencies by simulation.
        budget: Wall-clock seconds for the whole call: what takes longer fails.
        robot: An arm or its name: what bars its gripper's way to the objects of the order is then said.
        relations: The scene's relations where they are known, or where better ones are known: what they call
            disjoint has no contact, and no dependency rests on it.
        removal_risk: Chance that a removal does harm by itself, 0..1. Where it is given, more is taken than
            what must be, if that makes it less likely that anything moves: what touches a thing and is
            higher than it may lean on it unseen.
        beliefs: What earlier looks made of the same things: the risk is by all looks, what has to go before
            what by this one and by the lifts that were watched.
        check_gravity: Whether a scene is refused that would stand with another `up`. In one that is planned
            on, things may hang.
        hands: How many hands there are, one that takes and those that hold meanwhile. With it every step is
            asked about as things are by then, and what takes more hands is `unresolved`. Without it `holds`
            names what would take the groups apart.
        clamped: Names that a fixture, such as a vice, keeps where they stand until they are taken: a second
            hand that cannot move. Where `hands` is not given, there is one.

    Returns:
        The order. What must go before a target is what has a path to it in the dependency graph,
        so no smaller set will do.

    Raises:
        InvalidInput: The scene has no `up`, or hangs in the air with it and would stand with another; nothing
            in it can move, a target is fixed or hangs on a wrong mask, no hand, or the risk is no chance.
        UnknownObject: A target is not in the scene.
        OutOfBudget: The budget ran out.

    Examples:
        >>> order(scene, "book").order
        ('cup', 'book')
        >>> print(order(scene))
        to clear everything, take 2 of 2 movable objects in this order
        1  cup   likely  it rests on book.
        2  book  sure    after cup, because cup rests on it.
        Weakest contacts: book rests on table (0.96) and cup rests on book (0.96).
    """
    if hands is not None and hands < 1:
        raise InvalidInput(f"hands is {hands}: expected how many there are, 1 or more")
    if removal_risk is not None and not 0.0 <= removal_risk <= 1.0:
        raise InvalidInput(f"removal_risk is {removal_risk}: expected a chance from 0 to 1")
    situation = Situation.of(scene, relations)
    scene = situation.scene
    wanted = check_targets(scene, targets)
    fixture = check_clamped(scene, clamped)
    if fixture and hands is None:
        hands = 1
    sized = situation.sized
    statics = sized.statics
    if check_gravity:
        check_up(sized.scene, statics)
    beliefs = beliefs or Beliefs()
    full, chance = reason_out(situation)
    full = with_measured(full, beliefs.measured, situation)
    check_masks(situation, wanted, full)
    notes: dict[str, Any] = {}
    said = (*scene.assumptions, *assumed(scene, situation.statics))
    if verify:
        from topple.planner.simulate.votes import ask, chances, confirm

        votes = ask(situation.statics, full, seed)
        chance = chances(chance, votes, len(scene.viewpoints) or None)
        level = [edge for edge in full.dependencies if not sized.goes_up(edge.then)]  # simulation lifts
        chance |= {(edge.first, edge.then): edge.confidence for edge in level}
        full = _with_witnesses(confirm(full, chance, votes), situation)
        notes = {"trials": votes.trials}
    tops = {name: _top(statics.surfaces[name]) for name in full.names}
    apart = taking_apart(sized, full, hands, fixture)
    if fixture:
        full, chance = _kept_still(full, chance, statics, fixture)
    edges, chance = {(edge.first, edge.then) for edge in full.dependencies}, FrozenDict(chance)
    risked = beliefs.weigh(chance, edges) if beliefs.chances or beliefs.alone else chance
    found = arrange(full.reduced(), wanted, tops, sized.supports, said, risked, removal_risk, apart)
    found = replace(found, verified=verify, chances=chance, notes=FrozenDict(notes))
    found = replace(found, called=SpokenNames(scene))
    return found if robot is None else _with_access(found, situation, robot)


@checked_arguments
def order_all(
    scenes: Iterable[AnyScene],
    targets: Collection[str] | str | None = None,
    *,
    executor: Executor | None = None,
    **options: Any,
) -> list[Order]:
    """Order many scenes, on the workers of an executor where one is given.

    Args:
        scenes: Scenes, or paths of their files: the workers then read these, and clouds do not travel.
        targets: Names to free, each in every scene; none clears everything.
        executor: Any executor of `concurrent.futures`, or that of a dask client; a worker that is lost costs
            its scene a second try.
        **options: As for `order`; they pickle.

    Returns:
        The order of each scene.

    Raises:
        InvalidInput: As `order` and `load_scene`.
        WorkerLost: The worker of a scene was lost twice.

    Examples:
        >>> [found.order for found in order_all([scene], "book")]
        [('cup', 'book')]
    """
    return list(all_of(partial(_order_of, targets, options), scenes, executor))


def _order_of(
    targets: Collection[str] | str | None,
    options: dict[str, Any],
    source: AnyScene,
) -> Order:
    return order(source, targets, **options)


def _top(surface: FloatArray) -> FloatArray:
    """(3,) middle of the highest part of a surface, at its height [m]: of a flat top no point is the one."""
    height = surface[:, 2].max()
    return np.array([*surface[surface[:, 2] > height - TOP, :2].mean(axis=0), height])


ordered: Callable[..., Order] = partial(order, check_gravity=False)
"""The order of a scene that is planned on, which was checked when the plan began."""

cautious: Callable[..., Order] = partial(order, removal_risk=REMOVAL_RISK, check_gravity=False)
"""The order for an arm that acts: with the least risk, as removals do harm themselves now and then."""


def _with_witnesses(graph: DependencyGraph, situation: Situation) -> DependencyGraph:
    """The graph with a relation for what simulation alone found: that of what is lifted to what moves."""
    edges = (
        edge if edge.evidence else replace(edge, evidence=(situation.swept(edge.then, edge.first),))
        for edge in graph.dependencies
    )
    return DependencyGraph(graph.names, tuple(edges))


def _kept_still(
    full: DependencyGraph,
    chance: Mapping[tuple[str, str], float],
    statics: "Statics",
    fixture: frozenset[str],
) -> tuple[DependencyGraph, dict[tuple[str, str], float]]:
    """The dependencies that a fixture leaves, and the chances of what may still move."""
    left = with_fixture(full, statics, fixture)
    were, are = ({(edge.first, edge.then) for edge in graph.dependencies} for graph in (full, left))
    stays = {pair for pair in chance if pair in were or pair[0] in fixture} - are
    return left, {pair: each for pair, each in chance.items() if pair not in stays}


def _with_access(found: Order, situation: Situation, robot: "Arm | str") -> Order:
    """An order that also says what bars the gripper's way."""
    from topple.planner.planning.access import access  # arms are not wanted without a robot
    from topple.robots.catalog import robot as robot_named
    from topple.robots.catalog.own_arm import check_tool

    arm = robot_named(robot) if isinstance(robot, str) else robot
    check_tool(arm)
    ways = access(situation, found.order, found.graph, arm)
    said = [f"{arm.name} finds no grasp of {name}, whatever is taken away" for name in ways.graspless]
    return replace(found, access=ways.bars, assumptions=(*found.assumptions, *said))


def check_masks(
    scene: "Scene | Situation", targets: Collection[str], graph: DependencyGraph | None = None
) -> "Scene":
    """Refuse what hangs on a mask that is wrong in kind: that of a target, or of what has to go before one.

    Args:
        scene: The scene, or the situation it was read as.
        targets: What is asked for; none asks for no one mask.
        graph: What has to go before what, direct or not; worked out where None.

    Returns:
        The scene with its masks as they are: what is planned on it is not asked again.

    Raises:
        InvalidInput: It does; says which mask and what to do.
    """
    situation = Situation.of(scene)
    doubted = [wrong for wrong in situation.scene.wrong_masks if wrong.refuses]
    if not doubted:
        return situation.scene
    if targets:
        graph = dependencies(situation, direct=False) if graph is None else graph
        asked = [name for name in targets if name in graph.names]
        needed = {*asked}.union(*(graph.before(name) for name in asked))
        for wrong in doubted:
            if needed.intersection(wrong.names):
                raise InvalidInput(
                    f"{wrong}; what is asked of {', '.join(asked)} hangs on it: mend it, or go on with "
                    "--masks-as-they-are (Scene.with_masks_as_they_are)"
                )
    return situation.scene.with_masks_as_they_are()


def check_clamped(scene: "Scene", clamped: Collection[str] | str) -> frozenset[str]:
    """Refuse unknown names in a fixture; keep those of objects that can move.

    Args:
        scene: The scene.
        clamped: Names, one or several.

    Raises:
        UnknownObject: One is not in the scene.
    """
    return check_known(clamped, scene, scene.movable) - scene.fixed


def check_known(named: Collection[str] | str, scene: "Scene", known: Sequence[str]) -> frozenset[str]:
    """Refuse names of what is not there.

    Args:
        named: Names of objects, one or several.
        scene: The scene.
        known: What could have been meant.

    Raises:
        UnknownObject: One is not in the scene.
    """
    names = frozenset([named] if isinstance(named, str) else named)
    if unknown := sorted(names - scene.clouds.keys()):
        raise UnknownObject(unknown[0], known)
    return names


def check_targets(scene: "Scene", targets: Collection[str] | str | None) -> tuple[str, ...]:
    """The targets as a tuple without repeats, all of them known and movable.

    Args:
        scene: The scene.
        targets: Names, one or several; None for none.

    Raises:
        InvalidInput: A target is fixed, or everything is.
        UnknownObject: A target is not in the scene.
    """
    if not scene.movable:
        raise InvalidInput("nothing in the scene can move: every object is fixed")
    given = tuple(as_names(targets))
    for name in given:
        if name not in scene.clouds:
            raise UnknownObject(name, scene.movable, role="target")
        if name in scene.fixed:
            raise InvalidInput(
                f"target {name!r} is fixed and never moves: name one of {', '.join(scene.movable)}"
            )
    return tuple(dict.fromkeys(given))
