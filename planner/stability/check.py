"""Whether a scene stands, what holds what up, and by how much."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from topple.planner.stability.footing import Footing
from topple.planner.stability.margins import Carry, Direction, Island, Margins, beyond_support, islands_of
from topple.planner.stability.stack import as_stack
from topple.planner.stability.verdicts import GONE, STANDING, Finding, Verdict, find_held, find_verdicts
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.errors import InvalidInput
from topple.topology.io.load import AnyScene
from topple.topology.situation.situation import Situation


@dataclass(frozen=True)
class ObjectCheck:
    """What was found of one object.

    Attributes:
        name: The object.
        verdict: What becomes of it.
        others: What it penetrates, is above, is carried or was carried by; the first of them matters most.
        amount: Depth, gap, or how far its weight is beyond its support [m]; None where there is none.
        carried_by: What carries what stands, with forces.
        by_friction: Whether it stands by friction alone.
        margins: What it withstands, where it stands and that is known.
        falls_with: What does not stand once it is taken.

    Examples:
        >>> found = check(scene).objects["book"]
        >>> found.falls_with, round(found.margins.tilt, 2)
        (('cup',), 0.46)
    """

    name: str
    verdict: Verdict
    others: tuple[str, ...] = ()
    amount: float | None = None
    carried_by: tuple[Carry, ...] = ()
    by_friction: bool = False
    margins: Margins | None = None
    falls_with: tuple[str, ...] = ()

    @property
    def stands(self) -> bool:
        """Whether it stays where it is, as far as was seen."""
        return self.verdict in STANDING

    def sentence(self) -> str:
        """The verdict in words."""
        other = self.others[0] if self.others else "nothing"
        far = "" if self.amount is None else f"{1e3 * self.amount:.2g} mm"
        words = {
            Verdict.PENETRATES: f"is {far} deep in {other}",
            Verdict.FLOATS: f"floats {far} above {other}" if self.others else "floats above nothing",
            Verdict.FALLS: f"falls, since {other} does not stay under it",
            Verdict.TIPS: f"tips over the edge of {other}" + (f", {far} beyond" if far else ""),
            Verdict.SLIDES: f"slides on {' and '.join(self.others) or other}",
            Verdict.UNSEEN: "has unseen support: nothing seen carries it",
            Verdict.STANDS: "stands",
        }
        return f"{self.name} {words[self.verdict]}"

    def to_json(self) -> dict[str, Any]:
        """The object as the JSON of `topple check` has it: lengths in mm, angles in degrees, forces in N."""
        document: dict[str, Any] = {
            "object": self.name,
            "verdict": str(self.verdict),
            "stands": self.stands,
            "sentence": self.sentence(),
        }
        if self.others:
            document["others"] = list(self.others)
        if self.amount is not None:
            document["mm"] = round(1e3 * self.amount, 3)
        if self.margins is not None:
            document["margins"] = {
                "centre_mm": round(1e3 * self.margins.centre, 2),
                "tilt_degrees": round(float(np.degrees(self.margins.tilt)), 2),
                "push_newton": round(self.margins.push, 3),
                "centre_along": [round(value, 3) for value in self.margins.aside],
                "push_along": [round(value, 3) for value in self.margins.pushed],
            }
        if self.stands:
            document["carried_by"] = [
                {
                    "object": carry.name,
                    "newton": round(carry.force, 3),
                    "at": [round(value, 4) for value in carry.at],
                    "points": carry.points,
                    "inferred": carry.inferred,
                }
                for carry in self.carried_by
            ]
            document["by_friction"] = self.by_friction
            document["falls_with"] = list(self.falls_with)
        return document


@dataclass(frozen=True)
class StabilityCheck:
    """Whether a scene stands.

    Attributes:
        objects: What was found of each object that can move, in the scene's order.
        exact: Whether meshes were checked as they are; else clouds, within what noise leaves open.
        assumptions: What was assumed.

    Examples:
        >>> check(scene).stands
        True
    """

    objects: Mapping[str, ObjectCheck]
    exact: bool
    assumptions: tuple[str, ...] = ()

    @property
    def stands(self) -> bool:
        """Whether everything stays where it is, as far as was seen."""
        return all(each.stands for each in self.objects.values())

    def sentence(self) -> str:
        """The verdict in one line: how many stand, and what each of the others does."""
        standing = [each for each in self.objects.values() if each.stands]
        unseen = [each.name for each in standing if each.verdict is Verdict.UNSEEN]
        said = [f"{len(standing)} of {len(self.objects)} stand"]
        if unseen:
            said[0] += f" ({', '.join(unseen)} on what was not seen)"
        return "; ".join([*said, *(each.sentence() for each in self.objects.values() if not each.stands)])

    def to_json(self) -> dict[str, Any]:
        """The JSON of `topple check`."""
        return {
            "format": "topple.check",
            "format_version": 1,
            "stands": self.stands,
            "verdict": self.sentence(),
            "exact": self.exact,
            "objects": [each.to_json() for each in self.objects.values()],
            "assumptions": list(self.assumptions),
        }


@checked_arguments
def check(scene: AnyScene | Situation, *, margins: bool = True) -> StabilityCheck:
    """Ask of every object whether it stays where it is: by contacts and static equilibrium.

    Where everything has a mesh, or is a flat table, meshes are taken as they are; otherwise clouds, as far as
    their noise allows: what is beyond its support by less than 3 mm then stands.

    Args:
        scene: A scene that knows where up is, the path of one, or the situation it was read as.
        margins: Whether it is worked out what withstands how much, and what carries what: most of the time.

    Returns:
        A verdict for each object that can move; of what stands what carries it, what it withstands, and
        what falls if it is taken.

    Raises:
        InvalidInput: The scene has no `up`, or nothing in it can move.

    Examples:
        >>> found = check(scene).objects["cup"]
        >>> str(found.verdict), found.carried_by[0].name
        ('stands', 'book')
    """
    situation = Situation.of(scene)
    if not situation.movable:
        raise InvalidInput(
            "nothing in the scene can move: every object is fixed, so there is nothing to check"
        )
    footing = Footing.of(situation)
    verdicts = find_verdicts(footing)
    found = {name: _failed_check(name, verdict, footing) for name, verdict in verdicts.items()}
    names = [name for name, verdict in verdicts.items() if verdict.verdict in STANDING]
    gone = {name for name, verdict in verdicts.items() if verdict.verdict in GONE}
    contacts = [c for c in (*footing.contacts, *footing.unseen) if not gone.intersection((c.a, c.b))]
    for island in islands_of(footing, names, contacts) if margins else ():
        found |= _checks(as_stack(footing, island), verdicts, footing)
    return StabilityCheck(found, footing.exact, situation.scene.assumptions)


def _failed_check(name: str, finding: Finding, footing: Footing) -> ObjectCheck:
    """An object that does not stand, and by how much."""
    amount: float | None = None
    if finding.verdict is Verdict.PENETRATES:
        amount = footing.depths[name, finding.others[0]]
    elif finding.verdict is Verdict.FLOATS and finding.others:
        amount = footing.drops[name][finding.others[0]]
    elif finding.verdict is Verdict.TIPS and not find_held(footing, [name], footing.contacts):
        shift = beyond_support(footing, name, footing.contacts)
        amount = None if shift is None else shift[1]
    return ObjectCheck(name, finding.verdict, finding.others, amount)


def _checks(island: Island, verdicts: Mapping[str, Finding], footing: Footing) -> dict[str, ObjectCheck]:
    """Objects that stand together."""
    loads = island.loads()
    weights = island.weights if island.balanced else {}
    pushes = {
        name: island.push_margin(name, footing.tops[name] - weight.centre[2])
        for name, weight in weights.items()
    }
    return {
        name: ObjectCheck(
            name,
            verdicts[name].verdict,
            tuple(dict.fromkeys(carry.name for carry in loads[name])),
            None,
            loads[name],
            island.by_friction(name),
            _margins(island, name, pushes) if pushes else None,
            island.falls_without(name),
        )
        for name in island.names
    }


def _margins(island: Island, name: str, pushes: Mapping[str, tuple[float, Direction]]) -> Margins:
    """Measure the margins of an object, given the pushes of all that is above it."""
    centre, aside = island.centre_margin(name)
    push, pushed = min(pushes[other] for other in (name, *island.above(name)))
    return Margins(centre, island.tilt_margin, push, aside, pushed)
