"""Goals in the language of the relations: free the plate, lemon within bowl, red on green on blue."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import networkx as nx

from topple.planner.errors import NoSafePlan
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.values import Word
from topple.topology.sixim.table import Relation

if TYPE_CHECKING:
    from topple.topology.relations.relate import Relations
    from topple.topology.scene.scene import Scene
    from topple.topology.statics.support import Support

BIN = "bin_"
"""Objects named `bin_KIND` collect every object whose name starts with KIND when the goal is "sort"."""

GRAMMAR = 'goals are "A within B", "A on B on C", "empty B", "free A" or "sort", joined by "and" or commas'


class Action(Word):
    """What a step is for."""

    FREE = "free"
    """Take a target clear and put it down."""
    REMOVE = "remove"
    """Take away what is in the way."""
    PLACE = "place"
    """Put something where the goal says."""


class PlaceRelation(Word):
    """How something shall lie to what it is put to."""

    ON = "on"
    """On top of it, or on what lies there; not at its side, standing on what it stands on."""
    WITHIN = "within"
    """In its cavity, carried by it."""


@dataclass(frozen=True)
class Place:
    """An object and where it shall be in the end.

    Attributes:
        object: What is moved.
        how: On or within.
        where: Container or supporter.
    """

    object: str
    how: PlaceRelation
    where: str


@dataclass(frozen=True)
class Goal:
    """What shall hold in the end.

    Attributes:
        text: The goal in words.
        free: Objects to be lifted clear and put down elsewhere.
        empty: Containers that shall hold nothing in the end.
        places: Placements, in an order in which they can be made: what is below comes first.
        poses: Where things shall lie exactly: (4, 4) rigid transforms in the world from where each is at the
            start. Words leave that open.
        assumptions: What was assumed to read it, in sentences.
    """

    text: str
    free: tuple[str, ...] = ()
    empty: tuple[str, ...] = ()
    places: tuple[Place, ...] = ()
    poses: Mapping[str, FloatArray] = field(default_factory=dict[str, FloatArray], compare=False)
    assumptions: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Every object the goal names, without repeats."""
        placed = [name for place in self.places for name in (place.object, place.where)]
        return tuple(dict.fromkeys([*self.free, *self.empty, *placed]))

    def targets(self, inside: Mapping[str, Sequence[str]] | None = None) -> tuple[str, ...]:
        """The objects that must be taken in hand.

        Args:
            inside: container -> what lies in it, for the containers in `empty`.

        Returns:
            Names without repeats: what is freed, what is in a container to be emptied, what is placed.
        """
        held = [name for container in self.empty for name in (inside or {}).get(container, ())]
        return tuple(dict.fromkeys([*self.free, *held, *(p.object for p in self.places)]))

    def contents(self, relations: "Relations", fixed: Iterable[str] = ()) -> dict[str, tuple[str, ...]]:
        """List the objects in each container that shall be empty, by the relations of the scene."""
        away = set(fixed)
        found: dict[str, tuple[str, ...]] = {}
        for container in self.empty:
            others = [n for n in relations.objects if n != container and n not in away]
            if container not in relations.objects:
                continue
            found[container] = tuple(n for n in others if _is_in(relations, n, container))
        return found

    def unmet(
        self, relations: "Relations", fixed: Iterable[str] = (), carried: Iterable["Support"] | None = None
    ) -> tuple[str, ...]:
        """Clauses about relations that do not hold, in words; `free` needs a look at motion and is not one.

        Args:
            relations: The relations afterwards.
            fixed: Names that never move, which are in no container.
            carried: What carries what; where None, what touches a supporter is taken to be on it.
        """
        carried = None if carried is None else tuple(carried)
        missing = [
            f"{p.object} is not {p.how} {p.where}" for p in self.places if not holds(p, relations, carried)
        ]
        for container, names in self.contents(relations, fixed).items():
            missing += [f"{name} is still in {container}" for name in names]
        return tuple(missing)


def holds(place: Place, relations: "Relations", carried: Iterable["Support"] | None = None) -> bool:
    """Whether an object is where it shall be.

    Args:
        place: The object and where it shall be.
        relations: The scene's relations; an object that is not among them is nowhere.
        carried: What carries what; where None, what touches a supporter is taken to be on it.
    """
    if place.object not in relations.objects or place.where not in relations.objects:
        return False
    pairs = None if carried is None else tuple(carried)
    carriers = [pair for pair in pairs or () if pair.supported == place.object]
    below = _below(place.where, pairs or ())
    if any(pair.supporter in below and pair.kind != "leans" for pair in carriers):
        return False  # what stands beside a plate, on what that stands on, leans on its rim
    if _is_in(relations, place.object, place.where):
        return True  # on a plate or a tray an object lies within the hull of its rim: that is on it, too
    if place.how == PlaceRelation.WITHIN:
        return False
    if pairs is None:
        return relations.between(place.object, place.where).relation is Relation.TOUCH
    # what is at the side of a block leans on it, and on the table; what is on it has no one else
    return any(
        pair.supporter == place.where and (pair.kind != "leans" or len(carriers) == 1) for pair in carriers
    )


def _below(name: str, carried: Iterable["Support"]) -> set[str]:
    """Find all that carries an object, directly or not."""
    graph: nx.DiGraph[str] = nx.DiGraph([(pair.supporter, pair.supported) for pair in carried])
    return nx.ancestors(graph, name) if name in graph else set()


def _is_in(relations: "Relations", name: str, container: str) -> bool:
    return relations.between(name, container).relation in (Relation.WITHIN, Relation.PARTIAL_WITHIN)


def parse_goal(goal: str | Collection[str], scene: "Scene") -> Goal:
    """Read a goal.

    Args:
        goal: Words ("lemon within bowl", "red on green on blue", "empty bowl", "free plate", "sort"),
            clauses joined by commas or "and"; or names of objects to free.
        scene: The scene the names belong to; names may hold spaces.

    Returns:
        The goal.

    Raises:
        UnknownObject: A name is not in the scene.
        InvalidInput: The words are no goal, a fixed object is to move, or an object has two places.
        NoSafePlan: The placements contradict each other; the certificate is the cycle.
    """
    if not isinstance(goal, str):
        names = tuple(dict.fromkeys(_movable(name, scene) for name in goal))
        if not names:
            raise InvalidInput(f"no target is named: {GRAMMAR}")
        return Goal(" and ".join(f"free {name}" for name in names), free=names)
    text = " ".join(goal.split())
    if not text:
        raise InvalidInput(f"the goal is empty: {GRAMMAR}")
    free: list[str] = []
    empty: list[str] = []
    places: list[Place] = []
    for clause in clauses_in(text, scene):
        _read_clause(clause, scene, free, empty, places)
    ordered = _in_order(text, places)
    for name in free:
        if any(p.object == name for p in ordered):
            raise InvalidInput(f"goal {text!r} frees {name!r} and places it too: name one of the two")
    return Goal(text, tuple(dict.fromkeys(free)), tuple(dict.fromkeys(empty)), ordered)


def clauses_in(text: str, scene: "Scene") -> list[str]:
    """Split words at commas, semicolons and "and", but not inside the name of an object of the scene."""
    marked = text
    names = sorted((n for n in scene.clouds if re.search(r"[,;]|\band\b", n)), key=len, reverse=True)
    for i, name in enumerate(names):
        marked = marked.replace(name, f"\0{i}\0")
    parts = re.split(r"\s*[,;]\s*|\s+and\s+", marked)
    clauses = [re.sub(r"\0(\d+)\0", lambda m: names[int(m.group(1))], part).strip() for part in parts]
    return [clause for clause in clauses if clause]


def _read_clause(clause: str, scene: "Scene", free: list[str], empty: list[str], places: list[Place]) -> None:
    """Add what one clause asks for."""
    if clause == "sort" and "sort" not in scene.clouds:
        places.extend(_sort_places(scene))
        return
    verb, _, rest = clause.partition(" ")
    if verb == "free" and rest:
        free.append(_movable(rest, scene))
    elif verb == "empty" and rest:
        empty.append(_known_name(rest, scene))
    elif re.search(r"\s(within|in|on)\s", clause):
        places.extend(_chain(clause, scene))
    else:
        raise InvalidInput(f"goal {clause!r} is not understood: {GRAMMAR}")


def _chain(clause: str, scene: "Scene") -> list[Place]:
    """Placements of "A on B on C" or "A within B"."""
    words = re.split(r"\s(within|in|on)\s", clause)
    names, links = words[0::2], words[1::2]
    names = [_known_name(name.strip(), scene) for name in names]
    found: list[Place] = []
    for upper, link, lower in zip(names, links, names[1:], strict=False):
        if upper == lower:
            raise InvalidInput(f"goal {clause!r} puts {upper!r} {link} itself")
        found.append(
            Place(_movable(upper, scene), PlaceRelation.ON if link == "on" else PlaceRelation.WITHIN, lower)
        )
    return found


def _sort_places(scene: "Scene") -> list[Place]:
    """Every object into the bin of its kind; the longest kind that fits wins."""
    bins = sorted((n for n in scene.clouds if n.startswith(BIN)), key=len, reverse=True)
    if not bins:
        raise InvalidInput(
            f'goal "sort" needs objects named {BIN}KIND, the scene has {", ".join(scene.names)}'
        )
    found: list[Place] = []
    for name in scene.movable:
        if name in bins:
            continue
        home = next((b for b in bins if len(b) > len(BIN) and name.startswith(b[len(BIN) :])), None)
        if home is not None:
            found.append(Place(name, PlaceRelation.WITHIN, home))
    if not found:
        kinds = ", ".join(b[len(BIN) :] for b in sorted(bins))
        raise InvalidInput(f'goal "sort" finds no object whose name starts with {kinds}')
    return found


def _in_order(text: str, places: Sequence[Place]) -> tuple[Place, ...]:
    """Placements without repeats, lower ones first.

    Raises:
        InvalidInput: An object has two places.
        NoSafePlan: The placements go round in a circle.
    """
    unique = list(dict.fromkeys(places))
    home: dict[str, Place] = {}
    for place in unique:
        other = home.setdefault(place.object, place)
        if other != place:
            raise InvalidInput(
                f"goal {text!r} puts {place.object!r} both {other.how} {other.where!r} "
                f"and {place.how} {place.where!r}"
            )
    above: nx.DiGraph[str] = nx.DiGraph([(p.where, p.object) for p in unique])
    try:
        circle = [edge[1] for edge in nx.find_cycle(above)]
    except nx.NetworkXNoCycle:
        circle = []
    if circle:
        round_trip = " below ".join([*circle, circle[0]])
        raise NoSafePlan(f"goal {text!r} contradicts itself: {round_trip}", (f"cycle: {round_trip}",))
    rank = {name: i for i, name in enumerate(nx.topological_sort(above))}
    return tuple(sorted(unique, key=lambda p: rank[p.object]))


def _known_name(name: str, scene: "Scene") -> str:
    if name not in scene.clouds:
        raise UnknownObject(name, scene.names)
    return name


def _movable(name: str, scene: "Scene") -> str:
    if _known_name(name, scene) in scene.fixed:
        raise InvalidInput(
            f"{name!r} is fixed and never moves: name one of {', '.join(scene.movable) or 'nothing'}"
        )
    return name
