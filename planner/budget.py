"""A budget of wall-clock seconds for one call: it ends the call with a failure, and changes no answer.

Searches stop on counts of work, so that a busy machine gives the answer that an idle one gives, only later.
"""

import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from typing import ParamSpec, TypeVar

import numpy as np

from topple.topology.base.errors import InvalidInput, ToppleError

_P = ParamSpec("_P")
_R = TypeVar("_R")
_BUDGET: ContextVar[tuple[float, float]] = ContextVar("budget", default=(np.inf, np.inf))
"""Seconds that were given, and when they are over by `time.monotonic`."""


class OutOfBudget(ToppleError):
    """A call took longer than it was given; there is no answer of it."""


@contextmanager
def within(budget: float | None) -> Generator[None]:
    """Fail what is done inside once it took too long; of nested budgets the one that ends first counts.

    Args:
        budget: Wall-clock seconds [s], > 0; None for any.

    Raises:
        InvalidInput: The budget is no positive number.
        OutOfBudget: It ran out.
    """
    if budget is None:
        yield
        return
    if not budget > 0.0:
        raise InvalidInput(f"budget is {budget}: expected seconds above 0, or none")
    given = min((budget, time.monotonic() + budget), _BUDGET.get(), key=lambda each: each[1])
    token = _BUDGET.set(given)
    try:
        yield
        check_budget()
    finally:
        _BUDGET.reset(token)


def within_budget(call: Callable[_P, _R]) -> Callable[_P, _R]:
    """Have a function that takes a `budget` by name fail where that runs out."""

    @wraps(call)
    def inside(*args: _P.args, **options: _P.kwargs) -> _R:
        budget = options.get("budget")
        assert budget is None or isinstance(budget, (int, float))
        with within(budget):
            return call(*args, **options)

    return inside


def seconds_left() -> float:
    """Seconds until the budget is spent, infinite where there is none."""
    return _BUDGET.get()[1] - time.monotonic()


def check_budget() -> None:
    """Raise `OutOfBudget` where the budget is spent."""
    if seconds_left() <= 0.0:
        raise OutOfBudget(f"the budget of {_BUDGET.get()[0]:g} s ran out: give more, or none to let it end")
