"""What is tried where the plain way fails: one list, each entry with when it applies and what it tries.

A step that stands on none was found the plain way: the first object of the order, a grasp that nothing is in
the way of, a free place where it stays by itself, everything kept clear of. How many steps stand on each, and
how many of these succeed, is counted by `topple bench run` and told in docs/results.md; an entry that earns
nothing there has to go.
"""

from dataclasses import dataclass

from topple.topology.base.values import Word


class Fallback(Word):
    """The names that steps of plans and runs carry, from what to take down to how to get there."""

    ANOTHER_FIRST = "another first"
    MAKE_ROOM = "make room"
    LOOK_LONGER = "look longer"
    EMPTY = "empty"
    OTHER_TOOL = "other tool"
    LET_FALL_A_LITTLE = "let fall a little"
    WHERE_IT_ROLLS = "where it rolls"
    THROUGH_GUESSES = "through guesses"
    NARROW = "narrow"
    LET_FALL = "let fall"
    UNSEEN = "unseen"


@dataclass(frozen=True)
class Description:
    """What there is to say of a fallback.

    Attributes:
        when: Where it applies.
        tries: What it does there.
    """

    when: str
    tries: str


FALLBACKS: dict[Fallback, Description] = {
    Fallback.ANOTHER_FIRST: Description(
        "the first object of the order cannot be taken, and others wait for nothing either",
        "takes the next of those",
    ),
    Fallback.MAKE_ROOM: Description(
        "nothing that may go can be taken",
        "takes what barred the hand, or stands beside, out of the way, each thing once",
    ),
    Fallback.LOOK_LONGER: Description(
        "something is to go into a vessel that holds other things, and the best spots are not reached; or "
        "nothing that may go can be taken, and making room does not help",
        "asks for four times the spots and all hands: taking things out of a heap stirs it",
    ),
    Fallback.EMPTY: Description(
        "a vessel has no spot where the new thing disturbs nothing",
        "takes out what lies there, in its safe order",
    ),
    Fallback.OTHER_TOOL: Description(
        "the cup alone holds an object and finds no way, or a tool failed twice at it",
        "uses the arm's other tool",
    ),
    Fallback.LET_FALL_A_LITTLE: Description(
        "fingers below a flat thing have no room between it and the table",
        "lets it fall two centimetres more",
    ),
    Fallback.WHERE_IT_ROLLS: Description(
        "no place is reached where the object cannot roll",
        "puts it where it could",
    ),
    Fallback.THROUGH_GUESSES: Description(
        "fingers find no room beside neighbours as they were completed",
        "lets them into what was guessed of the neighbours; what was seen stays clear",
    ),
    Fallback.NARROW: Description(
        "no way keeps the usual distance with the object in the hand",
        "carries it past things at any distance",
    ),
    Fallback.LET_FALL: Description(
        "the object stays nowhere that the arm can put it, and a drop is allowed",
        "lets it go where it will fall, and says so",
    ),
    Fallback.UNSEEN: Description(
        "every hand at an object comes in through space that no camera saw to be empty",
        "takes it by one of these, where nothing else can be taken, and says so",
    ),
}
