"""Who stands: objects that nothing holds, and of these what fails by itself and what goes with it."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace

from topple.planner.stability.footing import Footing
from topple.planner.stability.tolerances import GRIPPING
from topple.topology.base.values import Word
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import islands
from topple.topology.statics.falling import falls
from topple.topology.statics.holding import deficits


class Verdict(Word):
    """What becomes of an object; the first that holds is told."""

    PENETRATES = "penetrates"
    FLOATS = "floats"
    FALLS = "falls"
    TIPS = "tips"
    SLIDES = "slides"
    UNSEEN = "unseen support"
    STANDS = "stands"


STANDING = (Verdict.UNSEEN, Verdict.STANDS)
GONE = (Verdict.FLOATS, Verdict.FALLS, Verdict.TIPS, Verdict.SLIDES)


@dataclass(frozen=True)
class Finding:
    """A verdict, and who else it is about.

    Attributes:
        verdict: What becomes of the object.
        others: What it is in, is above, was carried by, or stands on.
    """

    verdict: Verdict
    others: tuple[str, ...] = ()


def find_verdicts(footing: Footing) -> dict[str, Finding]:
    """Judge every object.

    What penetrates is taken to stay where it is, so that others are judged by themselves.

    Args:
        footing: What holds the scene up.

    Returns:
        name -> verdict, in the order of the weights.
    """
    found: dict[str, Finding] = {}
    for name in footing.weights:
        into = {b: deep for (a, b), deep in footing.depths.items() if a == name}
        if into:
            found[name] = Finding(Verdict.PENETRATES, tuple(sorted(into, key=lambda b: -into[b])))
    free = footing.weights.keys() - found.keys()
    falling = judge_fallen(footing, free, footing.contacts)
    if falling and footing.unseen:
        seen, falling = falling, judge_fallen(footing, free, (*footing.contacts, *footing.unseen))
        found |= {name: Finding(Verdict.UNSEEN) for name in seen if name not in falling}
    found |= falling
    return {name: found.get(name, Finding(Verdict.STANDS)) for name in footing.weights}


def find_held(footing: Footing, names: Collection[str], contacts: Iterable[Contact]) -> frozenset[str]:
    """Which of some objects forces at contacts hold; everything else counts as fixed."""
    weights = {name: weight for name, weight in footing.weights.items() if name in names}
    near = [contact for contact in contacts if contact.a in weights or contact.b in weights]
    left = deficits(weights, near)
    failing = {name for name in weights if left[name] > footing.lenience[name]}
    return frozenset(weights).difference(*(i for i in islands(weights, near) if not failing.isdisjoint(i)))


def judge_fallen(footing: Footing, free: Collection[str], contacts: Sequence[Contact]) -> dict[str, Finding]:
    """Judge what of some objects is not held; everything else counts as fixed.

    Args:
        footing: What holds the scene up.
        free: Names of the objects.
        contacts: What is there.

    Returns:
        name -> verdict, of those alone that are not held.
    """
    work = set(free) - find_held(footing, free, contacts)
    found: dict[str, Finding] = {}
    gone: list[str] = []
    while work:
        near = [c for c in contacts if c.a not in gone and c.b not in gone]
        failing = {
            n: _cause(n, footing, near, contacts, gone) for n in work if not find_held(footing, [n], near)
        }
        if not failing:
            standing = find_held(footing, work, near)
            work -= standing
            if not work:
                break
            failing = _first_to_move(work, footing, near)
        found |= failing
        gone += failing
        work -= failing.keys()
    return {name: found[name] for name in footing.weights if name in found}


def _cause(
    name: str, footing: Footing, near: Sequence[Contact], contacts: Sequence[Contact], gone: Collection[str]
) -> Finding:
    """Why an object is not held while everything that is left beside it stays."""
    lost = [other for other in footing.carriers(name, contacts) if other in gone]
    if lost:
        return Finding(Verdict.FALLS, tuple(lost))
    carriers = footing.carriers(name, near)
    if not carriers:
        drops = footing.drops.get(name, {})
        return Finding(Verdict.FLOATS, tuple(sorted(drops, key=drops.__getitem__))[:1])
    return Finding(_slides(footing, [name], near), tuple(carriers))


def _slides(footing: Footing, names: Collection[str], near: Iterable[Contact]) -> Verdict:
    """Whether friction is what is missing."""
    gripping = [replace(contact, friction=GRIPPING) for contact in near]
    return Verdict.SLIDES if find_held(footing, names, gripping) >= frozenset(names) else Verdict.TIPS


def _first_to_move(work: Collection[str], footing: Footing, near: Sequence[Contact]) -> dict[str, Finding]:
    """Of objects each of which would stand if the others stayed, those that give way first."""
    weights = {name: weight for name, weight in footing.weights.items() if name in work}
    closed = [replace(c, gaps=0.0 * c.gaps) for c in near if c.a in work or c.b in work]
    sinking = falls(weights, closed)
    moves = {name for name, fall in sinking.items() if fall.distance > 1e-4 or fall.angle > 1e-3} or {*work}
    carried = {name: footing.carriers(name, near) for name in moves}
    first = {name for name in moves if moves.isdisjoint(carried[name])} or moves
    verdict = _slides(footing, work, near)
    return {name: Finding(verdict, tuple(carried[name])) for name in first}
