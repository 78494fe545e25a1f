"""What is tried where the plain way fails: one list, each entry with when it applies and what it tries.

A step that stands on none was found the plain way: the first object of the order, a grasp that nothing is in
the way of, a free place where it stays by itself, everything kept clear of. How many steps stand on each, and
how many of these succeed, is counted by `topple bench run` and told in docs/results.md; an entry that earns
nothing there has to go.
"""

from topple.topology.base.values import Word


class Fallback(Word):
    """The names that steps of plans and runs carry, from what to take down to how to get there."""

    ANOTHER_FIRST = "another first"
    """The first object of the order cannot be taken, and others wait for nothing either: takes the next of
    those."""
    MAKE_ROOM = "make room"
    """Nothing that may go can be taken: takes what barred the hand, or stands beside, out of the way, each
    thing once."""
    LOOK_LONGER = "look longer"
    """Something is to go into a vessel that holds other things, and the best spots are not reached; or
    nothing that may go can be taken, and making room does not help: asks for four times the spots and all
    hands: taking things out of a heap stirs it."""
    EMPTY = "empty"
    """A vessel has no spot where the new thing disturbs nothing: takes out what lies there, in its safe
    order."""
    OTHER_TOOL = "other tool"
    """The cup alone holds an object and finds no way, or a tool failed twice at it: uses the arm's other
    tool."""
    LET_FALL_A_LITTLE = "let fall a little"
    """Fingers below a flat thing have no room between it and the table: lets it fall two centimetres more."""
    WHERE_IT_ROLLS = "where it rolls"
    """No place is reached where the object cannot roll: puts it where it could."""
    THROUGH_GUESSES = "through guesses"
    """Fingers find no room beside neighbours as they were completed: lets them into what was guessed of the
    neighbours; what was seen stays clear."""
    NARROW = "narrow"
    """No way keeps the usual distance with the object in the hand: carries it past things at any distance."""
    LET_FALL = "let fall"
    """The object stays nowhere that the arm can put it, and a drop is allowed: lets it go where it will fall,
    and says so."""
    UNSEEN = "unseen"
    """Every hand at an object comes in through space that no camera saw to be empty: takes it by one of
    these, where nothing else can be taken, and says so."""
