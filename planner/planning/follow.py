"""The loop of plans and runs: do what is chosen, until nothing is left to do or it goes on too long."""

from collections.abc import Callable

from topple.planner.planning.step import NextStep


def follow(choose: Callable[[], NextStep | None], do: Callable[[NextStep], None], most: int) -> bool:
    """Do one chosen step after the other.

    Args:
        choose: Gives the next step in the situation as it is by then; None where nothing is left to do.
        do: Does it: predicts where it leads, as a plan, or has an arm carry it out, as a run.
        most: Steps after which no other one is done.

    Returns:
        Whether nothing is left to do.

    Raises:
        NoSafePlan: As `choose`: something is left to do, and nothing that may be done now can be.
    """
    done = 0
    while (step := choose()) is not None:
        if done == most:
            return False
        do(step)
        done += 1
    return True
