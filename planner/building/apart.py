"""How what holds each other comes apart: with the fewest holds of a second hand."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import cache

import networkx as nx

from topple.planner.building.prefixes import Falling, Names, Prefixes, fewest_holds, in_units
from topple.planner.building.standing import falling_in, meeting_in
from topple.planner.decide.arrange import Apart, TakeApart
from topple.planner.decide.dependency import DependencyGraph
from topple.planner.decide.disturbance import fallen_without
from topple.planner.decide.hold import Hold, hands_for
from topple.topology.situation.situation import Situation
from topple.topology.statics.rest import Statics


def taking_apart(
    situation: Situation, full: DependencyGraph, hands: int | None, clamped: Names = frozenset()
) -> TakeApart:
    """Make the function that takes apart an order's groups; given hands, all else that does not stand too.

    A removal is a build backwards: whatever stands while things are put together with some holds also stands
    while they are taken apart, what was put down last first. The graph asks what falls with one thing gone
    and all others in place; this asks the same with several gone and some held.

    Args:
        situation: The scene.
        full: Its dependencies, with every edge. Those that static equilibrium does not find, since simulation
            did, are heeded too.
        hands: How many hands there are; None where nobody said, and the groups alone are asked about.
        clamped: What a fixture holds where it stands until it is taken.
    """
    over = [(then, first) for first, then in full.swept()]
    statics = situation.statics
    meeting = meeting_in(statics)
    falls = cache(lambda: _falling_as_graphs_ask(statics) if hands is None else falling_in(statics))

    def take_apart(steps: Sequence[str], groups: Sequence[Sequence[str]]) -> Apart:
        order, holds, hooked, proven = list(steps), list[Hold](), list[tuple[str, ...]](), True
        for part in groups if hands is None else [steps]:
            begin = steps.index(part[0])
            falling = _falling_of(falls(), situation, full, frozenset(part), frozenset(steps[:begin]))
            units, found = removals(part, over, falling, meeting, clamped & frozenset(part))
            taken = [units[k] for k in found.path]
            order[begin : begin + len(part)] = [name for unit in taken for name in unit]
            holds += [
                replace(
                    explain_hold(name, taken[since][0], taken[until][-1], taken[since][0], full, situation),
                    fixture=name in clamped,
                )
                for name, (since, until) in sorted(found.held.items(), key=lambda each: each[1])
            ]
            hooked += [unit for unit in taken if len(unit) > 1]  # in each other's way, whatever is held
            proven = proven and found.proven
        if hands is None:
            return Apart(tuple(order), tuple(holds), proven)
        lacking = [hold for hold in holds if not hold.fixture] if hands_for(order, holds) > hands else []
        unresolved = (*hooked, *((*hold.meanwhile(order), hold.object) for hold in lacking))
        return Apart(tuple(order), tuple(holds), proven, unresolved)

    return take_apart


def removals(
    group: Sequence[str],
    over: Collection[tuple[str, str]],
    falling: Falling,
    meeting: "nx.Graph[str]",
    clamped: Names = frozenset(),
) -> tuple[list[tuple[str, ...]], Prefixes]:
    """The order of removals that needs the fewest holds.

    Args:
        group: Names, those to be taken first first.
        over: (below, above): the lift of the first of each pair would meet the second.
        falling: What does not stand; nothing where everything is in place, and nothing that is held.
        meeting: Which objects are in contact.
        clamped: What a fixture holds until it is taken.

    Returns:
        What is taken at once, and in which order that is; each hold from when one of them is taken until
        another is.
    """
    units, before = in_units(group, over, lambda name: -group.index(name))
    built = fewest_holds(units, before, falling, meeting, clamped=clamped)
    last = len(units) - 1
    spans = {name: (last - until, last - since) for name, (since, until) in built.held.items()}
    return [unit[::-1] for unit in units], Prefixes(built.path[::-1], spans, built.proven)


def explain_hold(
    name: str, since: str, until: str, without: str, removals: DependencyGraph, situation: Situation
) -> Hold:
    """A hold with its reason.

    Args:
        name: What is held.
        since: What is put down or taken as the hold begins.
        until: What is down or gone when it ends.
        without: What it would move without.
        removals: Dependencies of removals.
        situation: The whole arrangement.
    """
    edge = removals.between(name, without)
    if edge is None:
        why = f"it does not stand safely without {without}"
        return Hold(name, since, until, why, situation.chain(name, without))
    return Hold(name, since, until, edge.sentence(), edge.evidence)


def _falling_of(
    falls: Falling, situation: Situation, full: DependencyGraph, part: Names, earlier: Names
) -> Falling:
    """Find the objects of a part that fall while it is taken apart, and did not before it was touched."""
    there = frozenset(situation.movable) - earlier
    rest, lifted, anyway = there - part, set(full.swept()), frozenset(falls(there, frozenset()))
    unseen = [
        (edge.first, edge.then)
        for edge in full.dependencies
        if {edge.first, edge.then} <= part and (edge.first, edge.then) not in lifted
        if edge.first not in falls(there - {edge.then}, frozenset())
    ]

    def falls_then(placed: Names, held: Names) -> Names:
        told = {first for first, then in unseen if then not in placed} - held
        return placed & (told | frozenset(falls(rest | placed, held))) - anyway

    return falls_then


def _falling_as_graphs_ask(statics: Statics) -> Falling:
    """Ask what falls of parts of an arrangement as the dependency graph does."""
    every = frozenset(statics.upright.movable)

    @cache
    def falls(placed: Names, held: Names) -> Names:
        return frozenset(fallen_without(statics, every - placed, held))

    return falls
