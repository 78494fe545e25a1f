"""Build order: how a finished arrangement is put together, base first, so that every part of it stands."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import networkx as nx

from topple.planner.building.apart import explain_hold
from topple.planner.building.prefixes import Falling, Names, fewest_holds, in_units
from topple.planner.building.standing import falling_in, meeting_in
from topple.planner.decide.arrange import Order
from topple.planner.decide.assumptions import assumptions
from topple.planner.decide.dependency import Dependency, DependencyGraph, Reason, reason_out
from topple.planner.decide.hold import Hold
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import FrozenDict
from topple.topology.io.load import AnyScene
from topple.topology.situation.situation import Situation
from topple.topology.statics.gravity import check_up
from topple.topology.statics.holding import deficits
from topple.topology.statics.rest import Statics, within_reach
from topple.topology.statics.tolerances import UNSTEADY

if TYPE_CHECKING:
    from topple.topology.relations.relate import Relations


class Footing(Dependency):
    """`first` has to be down before `then` is: the dependency of their removal, the other way round."""

    def sentence(self) -> str:
        """The reason in words."""
        if self.reason is Reason.BLOCKING:
            told = f"{self.then} would be in the way of putting {self.first} down"
            return f"{self.first} before {self.then}: {told}"
        return f"{self.first} before {self.then}: {self.removal().sentence()}"

    def removal(self) -> Dependency:
        """The dependency as it is when the two are taken away."""
        return Dependency(self.then, self.first, self.reason, self.confidence, self.evidence, self.lies)

    @staticmethod
    def of(removal: Dependency) -> "Footing":
        """Reverse a dependency between two removals into one for putting down."""
        first, then = removal.then, removal.first
        return Footing(first, then, removal.reason, removal.confidence, removal.evidence, removal.lies)


@dataclass(frozen=True, eq=False)
class BuildOrder(Order):
    """An order to put things down in, base first; its dependencies are `Footing`s.

    Attributes:
        footings: What the order keeps, also what follows from the direct ones of `graph`.

    Examples:
        >>> build_order(scene).next.object
        'book'
    """

    footings: tuple[Footing, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The object that `topple order --build --json` prints."""
        return {**super().to_json(), "build": True}


@checked_arguments
def build_order(scene: AnyScene | Situation, *, relations: "Relations | None" = None) -> BuildOrder:
    """Find in which order to put down the things of a finished arrangement.

    Each is lowered straight down into its place, past nothing that already stands (6IM of the swept body);
    what is down stands by itself (static equilibrium), or is held until it does, with the fewest holds.

    Args:
        scene: The finished arrangement, which knows where up is, or the situation it was read as.
        relations: Its relations where they are known.

    Returns:
        The order. What hooks into each other goes down together, as a group.

    Raises:
        InvalidInput: The scene has no `up`, or hangs in the air with it and would stand with another; nothing
            in it can move.

    Examples:
        >>> build_order(scene).order
        ('book', 'cup')
    """
    seen = Situation.of(scene, relations)
    situation = seen.sized
    scene, statics = situation.scene, situation.statics
    if not scene.movable:
        raise InvalidInput("nothing in the scene can move: every object is fixed")
    check_up(scene, statics)
    full, chances = reason_out(situation)
    over = [(then, first) for first, then in full.swept()]
    meeting, falling = meeting_in(statics), falling_in(statics)
    low = {name: float(statics.surfaces[name][:, 2].min()) for name in scene.movable}
    parts = nx.connected_components(nx.Graph([*meeting.edges, *over, *((n, n) for n in meeting)]))
    steps: list[str] = []
    holds: list[Hold] = []
    groups: list[tuple[str, ...]] = []
    proven = True
    for part in sorted(parts, key=lambda names: min(map(scene.movable.index, names))):
        units, before = in_units(part, over, lambda name: (round(low[name], 2), name))
        others = frozenset(scene.movable) - part
        found = fewest_holds(units, before, partial(_standing_beside, falling, others), meeting)
        chosen = [units[k] for k in found.path]
        steps += [name for unit in chosen for name in unit]
        groups += [unit for unit in chosen if len(unit) > 1]
        holds += [
            explain_hold(name, chosen[first][-1], chosen[last][-1], chosen[last][-1], full, situation)
            for name, (first, last) in sorted(found.held.items(), key=lambda each: each[1])
        ]
        proven = proven and found.proven
    place = {name: k for k, name in enumerate(steps)}
    kept = tuple(Footing.of(e) for e in full.dependencies if place[e.then] < place[e.first])
    graph = DependencyGraph(full.names, kept).reduced()
    return BuildOrder(
        targets=(),
        order=tuple(steps),
        graph=graph,
        supports=situation.supports,
        groups=tuple(groups),
        unresolved=(),
        risk=FrozenDict(_risks(steps, holds, chances)),
        assumptions=(*scene.assumptions, *assumptions(seen.scene, seen.statics), *_unsteady(statics)),
        explanation=_explain(steps, holds, groups, graph),
        chances=FrozenDict({(then, first): chance for (first, then), chance in chances.items()}),
        holds=tuple(holds),
        proven=proven,
        footings=kept,
    )


def _standing_beside(falling: Falling, others: Names, placed: Names, held: Names) -> Names:
    """Find the objects of a part that fall while all that it does not hang together with is there."""
    return placed & frozenset(falling(placed | others, held))


def _unsteady(statics: Statics) -> tuple[str, ...]:
    """Name the objects that do not stand in the finished arrangement, as far as weights are known."""
    found = [name for name, missing in statics.unexplained.items() if missing > UNSTEADY]
    said = [f"{name} stands in the whole arrangement, though its contacts do not show how" for name in found]
    return (*said, *_hidden_props(statics))


def _hidden_props(statics: Statics) -> list[str]:
    """Name objects that fall but for an unseen contact, of bodies that cameras did not hide parts of."""
    seen = [contact for contact in statics.contacts if not contact.inferred]
    if statics.sight is not None or len(seen) == len(statics.contacts):
        return []
    without = deficits(statics.weights, within_reach(seen, statics.weights))
    return [
        f"{name} would not stand on what it touches: something that is not in its cloud is taken to carry it"
        for name, missing in without.items()
        if missing > UNSTEADY >= statics.unexplained[name]
    ]


def _risks(
    steps: Sequence[str], holds: Sequence[Hold], chances: Mapping[tuple[str, str], float]
) -> dict[str, float]:
    """Chance that a thing moves as it is put down, since something that is still to come carries it."""
    held = {hold.object for hold in holds}
    return {
        name: 0.0 if name in held else 1.0 - math.prod(1.0 - chances.get((name, n), 0.0) for n in steps[k:])
        for k, name in enumerate(steps, start=1)
    }


def _explain(
    steps: Sequence[str],
    holds: Sequence[Hold],
    groups: Sequence[tuple[str, ...]],
    graph: DependencyGraph,
) -> tuple[str, ...]:
    """One sentence per step: what had to be down before it, and what is held."""
    told: list[str] = []
    for number, name in enumerate(steps, start=1):
        why = [edge.sentence() for edge in graph.dependencies if edge.then == name]
        said = "; ".join(why) or "nothing has to be down before it"
        for hold in holds:
            if hold.since == name:
                said += f"; hold {hold.object} until {hold.until} is down: {hold.because}"
            if hold.until == name:
                said += f"; then let {hold.object} go"
        for group in groups:
            if name == group[0]:
                said += f"; {' and '.join(group)} hook into each other: put them down together"
        told.append(f"{number}. {name}: {said}")
    return tuple(told)
