"""The relaxations: one ordered table of what is tried where the plain way fails.

A step that stands on none was found the plain way: the first object of the order, a grasp that nothing is in
the way of, a free place where it stays by itself, everything kept clear of. A row that earns nothing in
`topple bench run` has to go.
"""

from collections.abc import Collection

from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import Word


class Relaxation(Word):
    """A row of the table, equal to its name, which steps of plans and runs carry.

    Attributes:
        saved: Steps of the 3,951 in benchmarks/run.md that stood on it and succeeded; None: not counted yet.
        when: Where it is tried.
        changes: What is done instead of the plain way.

    Examples:
        >>> Relaxation.NARROW.when
        'no way keeps the usual distance with the object in the hand'
    """

    saved: int | None
    when: str
    changes: str

    def __new__(cls, name: str, saved: int | None = None, when: str = "", changes: str = "") -> "Relaxation":
        """Make a row of its name and what it says."""
        row = str.__new__(cls, name)
        row._value_, row.saved, row.when, row.changes = name, saved, when, changes
        return row

    ANOTHER_FIRST = (
        *("another first", 22, "the first object of the order cannot be taken, and others need not wait"),
        "takes the next of those",
    )
    MAKE_ROOM = (
        *("make room", 61, "nothing that may go can be taken"),
        "takes what barred the hand, or stands beside, out of the way, each thing once",
    )
    LOOK_LONGER = (
        *("look longer", 19, "nothing that may go can be taken, or no good spot in a vessel is reached"),
        "asks for four times the spots and all hands: taking things out of a heap stirs it",
    )
    EMPTY = (
        *("empty", 52, "a vessel has no spot where the new thing disturbs nothing"),
        "takes out what lies there, in its safe order",
    )
    OTHER_TOOL = (
        *("other tool", 46, "the cup alone holds an object and finds no way, or a tool failed twice at it"),
        "uses the arm's other tool",
    )
    LET_FALL_A_LITTLE = (
        *("let fall a little", 60, "fingers below a flat thing have no room between it and the table"),
        "lets it fall two centimetres more",
    )
    WHERE_IT_ROLLS = (
        *("where it rolls", 297, "no place is reached where the object cannot roll"),
        "puts it where it could",
    )
    THROUGH_GUESSES = (
        *("through guesses", 24, "fingers find no room beside neighbours as they were completed"),
        "lets them into what was guessed of the neighbours; what was seen stays clear",
    )
    NARROW = (
        *("narrow", 11, "no way keeps the usual distance with the object in the hand"),
        "carries it past things at any distance",
    )
    LET_FALL = (
        *("let fall", 0, "the object stays nowhere that the arm can put it, and a drop is allowed"),
        "lets it go where it will fall, and says so",
    )
    UNSEEN = (
        *("unseen", None, "every hand at an object comes in through space that no camera saw to be empty"),
        "takes it by one of these, where nothing else can be taken, and says so",
    )


RELAXATIONS = tuple(Relaxation)
"""In the order in which they are told of: from what to take down to how to get there."""


def select(names: Collection[str] | str) -> frozenset[Relaxation]:
    """The relaxations of some names.

    Args:
        names: One or several of `RELAXATIONS`.

    Raises:
        InvalidInput: One is none.
    """
    given = {names} if isinstance(names, str) else set(names)
    if unknown := sorted(given.difference(RELAXATIONS)):
        raise InvalidInput(f"unknown relaxation {unknown[0]!r}: expected some of {', '.join(RELAXATIONS)}")
    return frozenset(map(Relaxation, given))
