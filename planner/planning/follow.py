"""The loop of plans and runs: do what is chosen, until nothing is left to do or it goes on too long."""

from collections.abc import Callable

from topple.planner.decide.goal import Goal
from topple.planner.errors import NoSafePlan
from topple.planner.fallbacks import RELAXATIONS
from topple.planner.planning.step import Context, NextStep, Task
from topple.topology.situation.situation import Situation


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


def next_step(task: Task, situation: Situation, goal: Goal, context: Context) -> NextStep | None:
    """Ask a task for the next step in a situation; None where nothing is left to do.

    Args:
        task: What is to be reached.
        situation: What is seen, or what should be there by now.
        goal: The same, read for the scene at the start.
        context: What the step is chosen in.

    Raises:
        NoSafePlan: Nothing that may be done now can be; says too which relaxations the caller left out.
    """
    try:
        return task.chooser(situation, goal, context).choose()
    except NoSafePlan as error:
        left = [name for name in RELAXATIONS if name not in context.relaxations]
        if not left:
            raise
        words = f"not tried, as the relaxations leave it out: {', '.join(left)}"
        raise NoSafePlan(f"{error}; {words}", (*error.certificate, words), error.failures) from error
