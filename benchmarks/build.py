"""How many partial arrangements stand when a finished one is put together, against simple orders.

Seeded arrangements (piles, towers, bridges, arches, card houses, balances, nested dishes, books) are
settled in PyBullet and seen. Each order is then carried out there by ideal placements: every thing is lowered
straight down into its place, rigidly, at 8 cm/s, and let go; what is to be held is kept still meanwhile.
A prefix stands where nothing that is down, and is not held, moves by 1 cm or 10 degrees, neither while the
last thing comes nor in two seconds after it was let go. Each prefix begins with everything in its place, so
that what went wrong before is not counted twice.

The baselines are given the same clouds and hold nothing:

- height: the lowest top first,
- plain 6IM + height: of two objects that are not disjoint by the paper's rule, the lower mean first,
- random topological: any order in which what carries comes before what it carries, by topple's supports.

The same arrangements are then cleared in the order that topple gives two hands, by ideal lifts: what is to be
held is kept still while others are taken. One hand clears those of them in which nothing is to be held.

Shares have Wilson's 95 % intervals. Seeds from `FIRST` on chose nothing.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from statistics import median
from time import perf_counter, process_time
from typing import Any

import networkx as nx
import numpy as np

from topple.benchmarks.arrangements import KINDS, arrangement
from topple.benchmarks.guesses import naive, top_height
from topple.benchmarks.piles import Pile, observe
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import share
from topple.planner.building.build import BuildOrder, build_order
from topple.planner.decide.hold import Hold
from topple.planner.planning.order import order
from topple.planner.simulate.lifts import set_friction, take_away
from topple.planner.simulate.tolerances import SPEED, WATCHED
from topple.planner.tolerances import DISTURBED, TURNED
from topple.robots.poses import angle_between
from topple.robots.world.world import World
from topple.topology.base.arrays import bounds
from topple.topology.base.errors import ToppleError
from topple.topology.base.workers import Lost, map_tasks, open_executor
from topple.topology.situation.situation import Situation

FIRST = 2_200_000
ARRANGEMENTS = 200
BAR = ">= 97"
VIEWS = {0: "whole surfaces", 3: "3 cameras"}

Names = frozenset[str]


def rows(
    quick: bool,
    seed: int,
    progress: Progress,
    *,
    minutes: float | None = None,
    executor: Executor | None = None,
) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Ten arrangements.
        seed: Transfers on to other arrangements.
        progress: Called before each part.
        minutes: Begin no arrangement but the first after that time.
        executor: Whose workers try them; None for a process a core.

    Returns:
        The bench's rows.
    """
    count, counts, until = (10 if quick else ARRANGEMENTS), Counts(), None
    if minutes is not None:
        until = perf_counter() + 60 * minutes
    seeds = [FIRST + 1000 * seed + number for number in range(count)]
    waiting = (one for k, one in enumerate(seeds) if not k or until is None or perf_counter() < until)
    found: dict[int, Trials] = {}
    with open_executor(executor) as pool:
        for answer in map_tasks(tried, waiting, pool, in_turn=False):
            if isinstance(answer, Lost):
                raise ToppleError(f"arrangement {answer.task} was lost with the process that tried it")
            found[answer.seed] = answer
            progress(f"arrangement {len(found)} of {count}: {answer.kind}")
    for one in sorted(found):
        counts.add(found[one])
    seconds = [looked.seconds for each in found.values() for looked in each.looks]
    measured = [*counts.rows(), Row("build_order, median, CPU time", median(seconds), "s")]
    return [row.to_json() for row in [Row("arrangements", len(found), ""), *measured]]


@dataclass(frozen=True)
class Look:
    """What became of an arrangement as it was seen.

    Attributes:
        view: How many cameras saw it; 0: whole surfaces.
        held: Whether topple's build order holds something.
        prefixes: Whose order -> whether each of its prefixes stood.
        cleared: How it was cleared by two hands.
        seconds: CPU time of the build order, relations included [s].
    """

    view: int
    held: bool
    prefixes: Mapping[str, tuple[bool, ...]]
    cleared: "Cleared"
    seconds: float


@dataclass(frozen=True)
class Trials:
    """An arrangement that was put together and cleared in every order."""

    seed: int
    kind: str
    looks: tuple[Look, ...]


def tried(seed: int) -> Trials:
    """Put an arrangement together, and clear it, in every order that somebody gives.

    Args:
        seed: Of the arrangement.
    """
    kind, pile = arrangement(seed)
    trial, looks = Trial(pile), list[Look]()
    for view in VIEWS:
        scene = observe(pile, view, seed)
        if set(scene.movable) != set(pile.poses):
            continue  # a thing that no camera sees is in nobody's order
        started = process_time()
        situation = Situation(scene)  # read once, for every order of topple's
        found = build_order(situation)
        seconds = process_time() - started
        prefixes = {"topple": tuple(trial.stands(found.order, found))}
        for name, baseline in _baselines(situation, seed).items():
            prefixes[name] = tuple(trial.stands(baseline))
        looks.append(Look(view, bool(found.holds), prefixes, _cleared(situation, trial), seconds))
    return Trials(seed, kind, tuple(looks))


def _cleared(situation: Situation, trial: "Trial") -> "Cleared":
    """How an arrangement is cleared with two hands."""
    found = order(situation, hands=2)
    calm = trial.cleared(found.order, found.holds)
    return Cleared(
        holds=bool(found.holds),
        planned=not found.unresolved,
        calm=calm,
        unheld=trial.cleared(found.order) if found.holds else calm,
        unasked=trial.cleared(order(situation).order),
    )


def _baselines(situation: Situation, seed: int) -> dict[str, tuple[str, ...]]:
    scene = situation.scene
    carried: nx.DiGraph[str] = nx.DiGraph()
    carried.add_nodes_from(scene.movable)
    carriers = ((s.supporter, s.supported) for s in situation.supports)
    carried.add_edges_from((a, b) for a, b in carriers if a not in scene.fixed)
    draw = dict(zip(scene.movable, np.random.default_rng(seed).permutation(len(carried)), strict=True))
    units = nx.condensation(carried)  # what seems to carry each other comes in any order
    members = {c: sorted(units.nodes[c]["members"], key=draw.__getitem__) for c in units}
    random = nx.lexicographical_topological_sort(units, lambda c: draw[members[c][0]])
    return {
        "height": top_height(scene).order[::-1],
        "plain 6IM + height": naive(scene).order[::-1],
        "random topological": tuple(name for c in random for name in members[c]),
    }


@dataclass
class Counts:
    """Prefixes that stood, by view, order and kind; whole arrangements built; and those that need a hold."""

    stood: dict[tuple[int, str, str], list[bool]] = field(
        default_factory=dict[tuple[int, str, str], list[bool]]
    )
    built: dict[tuple[int, str], list[bool]] = field(default_factory=dict[tuple[int, str], list[bool]])
    free: dict[tuple[int, str], list[bool]] = field(default_factory=dict[tuple[int, str], list[bool]])
    cleared: "dict[int, list[Cleared]]" = field(default_factory=lambda: {})

    def add(self, trials: Trials) -> None:
        """Count one arrangement."""
        for look in trials.looks:
            self.cleared.setdefault(look.view, []).append(look.cleared)
            for who, prefixes in look.prefixes.items():
                self.stood.setdefault((look.view, who, trials.kind), []).extend(prefixes)
                self.built.setdefault((look.view, who), []).append(all(prefixes))
                if not look.held:
                    self.free.setdefault((look.view, who), []).extend(prefixes)

    def cleared_rows(self) -> list[Row]:
        """What one hand clears, and two."""
        found: list[Row] = []
        for view, each in self.cleared.items():
            where, one = VIEWS[view], [c.planned and not c.holds for c in each]
            two, calm = [c.planned for c in each], [c.planned and c.calm for c in each]
            alone = [c.calm and planned for c, planned in zip(each, one, strict=True)]
            held = [c for c in each if c.holds]  # by as many hands as are named
            what = f"cleared where something is held ({len(held)}), {where}"
            found += [
                _row(f"an order for two hands, {where}", two, "one hand", one),
                _row(f"cleared by two hands, {where}", calm, "one hand", alone),
                _row(f"cleared by two hands, {where}", calm, "without --hands", [c.unasked for c in each]),
                _row(what, [c.calm for c in held], "nothing held", [c.unheld for c in held]),
            ]
        return found

    def rows(self) -> list[Row]:
        """The figures, topple's beside each baseline's."""
        found: list[Row] = []
        for view, where in VIEWS.items():
            ours, others = self._all(view, "topple"), ("height", "plain 6IM + height", "random topological")
            for other in others:
                bar = BAR if view == 0 and other == others[0] else None
                theirs = self._all(view, other)
                found.append(_row(f"prefixes that stand, {where}", ours, other, theirs, bar))
            for other in others:
                mine, theirs = self.free.get((view, "topple"), []), self.free.get((view, other), [])
                found.append(_row(f"the same where nothing is held, {where}", mine, other, theirs))
            for other in others:
                mine, theirs = self.built[view, "topple"], self.built[view, other]
                found.append(_row(f"arrangements built, {where}", mine, other, theirs))
        for kind in KINDS:
            if mine := self.stood.get((0, "topple", kind)):
                what = f"prefixes that stand, {kind}, {VIEWS[0]}"
                found.append(_row(what, mine, "height", self.stood[0, "height", kind]))
        return found + self.cleared_rows()

    def _all(self, view: int, who: str) -> list[bool]:
        return [one for kind in KINDS for one in self.stood.get((view, who, kind), ())]


def _row(what: str, ours: Sequence[bool], name: str, theirs: Sequence[bool], bar: str | None = None) -> Row:
    return share(what, sum(ours), len(ours), bar, against=(name, sum(theirs), len(theirs)))


@dataclass(frozen=True)
class Cleared:
    """How an arrangement is cleared with two hands.

    Attributes:
        holds: Whether something is held.
        planned: Whether two hands are enough.
        calm: Whether all others stay in place, lift by lift, with what is to be held kept still.
        unheld: The same where nothing is held.
        unasked: The same of the order that says nothing of hands, nothing held.
    """

    holds: bool
    planned: bool
    calm: bool
    unheld: bool
    unasked: bool


class Trial:
    """An arrangement that is put together in simulation; what was seen of a prefix is kept."""

    def __init__(self, pile: Pile) -> None:
        self._pile = pile
        self._bodies = {body.name: body for body in pile.bodies}
        self._known: dict[tuple[Names, Names, str | None], bool] = {}
        self._lifts: dict[tuple[Names, Names, str], bool] = {}

    def stands(self, order: Sequence[str], found: BuildOrder | None = None) -> list[bool]:
        """Whether each prefix of an order stands, with the holds of a build order."""
        at = {name: k for k, name in enumerate(order)}
        spans = [(h.object, at[h.since], at[h.until]) for h in (found.holds if found else ())]
        together = {name: frozenset(group) for group in (found.groups if found else ()) for name in group}
        verdicts: list[bool] = []
        for k, name in enumerate(order):
            unit = together.get(name, frozenset({name}))
            if name in together and any(other in unit for other in order[k + 1 :]):
                continue  # a prefix ends with all of them
            there = frozenset(order[: k + 1])
            meanwhile = frozenset(n for n, first, last in spans if first <= k <= last and n not in unit)
            after = frozenset(n for n, first, last in spans if first <= k < last)
            calm = len(unit) > 1 or self._still(there, meanwhile, name)
            verdicts.append(calm and self._still(there, after, None))
        return verdicts

    def cleared(self, order: Sequence[str], holds: Sequence[Hold] = ()) -> bool:
        """Whether nothing else moves while things are taken in an order, some of them held meanwhile."""
        at = {name: k for k, name in enumerate(order)}
        spans = [(hold.object, at[hold.since], at[hold.until]) for hold in holds]
        for k, name in enumerate(order):
            there = frozenset(order[k:])
            held = frozenset(n for n, first, last in spans if first <= k <= last and n != name)
            kept = frozenset(n for n, first, last in spans if first <= k < last)
            if not self._calm(there, held, name) or (
                kept < held and not self._still(there - {name}, kept, None)
            ):
                return False
        return True

    def _calm(self, there: Names, held: Names, going: str) -> bool:
        """Whether all others stay in place while one is lifted away."""
        if (there, held, going) not in self._lifts:
            with self._world(there, held) as world:
                moves = take_away(world, going)
            calm = not any(moves[n].beyond(DISTURBED, np.degrees(TURNED)) for n in moves.keys() - held)
            self._lifts[there, held, going] = calm
        return self._lifts[there, held, going]

    def _world(self, there: Names, held: Names) -> World:
        """Some of the things in place, some of them kept still."""
        world = World()
        world.add_table(size=(0.8, 0.8))
        for name in sorted(there):
            world.add(self._bodies[name], self._pile.poses[name], fixed=name in held)
        set_friction(world, 0.5, 0.6, dict.fromkeys(held, float(np.sqrt(0.5))))
        return world

    def _still(self, there: Names, held: Names, coming: str | None) -> bool:
        key = there, held, coming
        if key not in self._known:
            self._known[key] = self._watch(there, held, coming)
        return self._known[key]

    def _watch(self, there: Names, held: Names, coming: str | None) -> bool:
        """Whether all stay in place while one of them is lowered, or where none is, for a while."""
        poses = self._pile.poses
        with self._world(there, held) as world:
            if coming is None:
                for _ in range(round(WATCHED / world.time_step / 24)):
                    world.step(24)
                    if world.at_rest():
                        break
            else:
                _lower(world, coming)
            after = {name: world.pose(name) for name in there - held - {coming}}
        return all(
            float(np.linalg.norm((pose - poses[name])[:3, 3])) <= DISTURBED
            and angle_between(pose, poses[name]) <= TURNED
            for name, pose in after.items()
        )


def _lower(world: World, name: str) -> None:
    """Bring a body straight down into its place, from above all that it passes."""
    place, mine = world.pose(name), np.concatenate(world.parts(name))
    low, high = bounds(mine)
    tops = [float(low[2])]
    for other in world.movable:
        least, most = bounds(np.concatenate(world.parts(other)))
        if other != name and (least < high)[:2].all() and (most > low)[:2].all():
            tops.append(float(most[2]))
    step = SPEED * world.time_step
    for height in np.arange(max(tops) + 0.005 - float(low[2]), -step, -step):
        pose = place.copy()
        pose[2, 3] += max(float(height), 0.0)
        world.place(name, pose)
        world.step()
