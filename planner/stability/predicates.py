"""What holds in a world now, physically: `topple.predicates`, for success and rewards in any simulator.

A predicate is asked of MuJoCo's (model, data), of PyBullet's client, of a world of topple, or of a Scene:

>>> import topple
>>> from topple.predicates import On
>>> scene = topple.load_scene("scene.npz")
>>> On("mug", "book")(scene)
True

It answers True, False, or None where that cannot be told: something still moves, forces were never computed,
or nothing seen carries it. What a hand holds over a plate is not on it: there has to be contact, and load.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from topple.planner.stability.state import State
from topple.planner.stability.tolerances import CARRIES, HELD_BY_OTHERS, STEADY

__all__ = ["Clear", "In", "On", "Predicate", "Stable", "State", "Supports"]


@dataclass(frozen=True)
class Predicate(ABC):
    """Something that may hold in a world; see the subclasses."""

    def __call__(self, world: Any, data: Any = None) -> bool | None:
        """Whether it holds now.

        Args:
            world: What `State.of` takes; a State where several are asked of one instant.
            data: The `mujoco.MjData` where `world` is a model.

        Returns:
            True, False, or None where that cannot be told.

        Raises:
            InvalidInput: The world is nothing of the kind.
            UnknownObject: A name is not there.
        """
        state = State.of(world, data)
        state.check(*(name for name in vars(self).values() if isinstance(name, str)))
        return self.told(state)

    @abstractmethod
    def told(self, state: State) -> bool | None:
        """Evaluate the predicate in a state that has all the names."""


@dataclass(frozen=True)
class On(Predicate):
    """One body rests on another, which carries it.

    They touch, the other pushes up with at least `share` of its weight, and it is at rest on that: a tray
    may move. Not on it is what leans on it, or is held over it. None where it moves on it.

    Attributes:
        object: The body.
        carrier: What carries it.
        share: Of its weight that has to be carried.
    """

    object: str
    carrier: str
    share: float = CARRIES

    def told(self, state: State) -> bool | None:
        """See the class."""
        pair = self.object, self.carrier
        touching = pair in state.pushes
        if self.object not in state.weights:
            return False  # what is fixed needs nothing to carry it
        if pair in state.doubted or (touching and (state.up is None or not state.pressed)):
            return None
        if not touching or state.lift(*pair) < self.share * state.weights[self.object]:
            return False
        return True if state.rests(self.object, self.carrier) else None


@dataclass(frozen=True)
class In(Predicate):
    """One body is in the hollow of another and stays there.

    Its centre of mass is over the outline of the container, its lowest point below the rim; it meets the
    container or what else is in that, and is at rest in it. None where it moves, or something else holds it.

    Attributes:
        object: The body.
        container: What it is in.
    """

    object: str
    container: str

    def told(self, state: State) -> bool | None:
        """See the class."""
        if not state.within(self.object, self.container):
            return None if (self.object, self.container) in state.doubted else False
        weight = state.weights.get(self.object, 0.0)
        others = [b for a, b in state.pushes if a == self.object and b != self.container]
        held = sum(
            float(np.linalg.norm(state.pushes[self.object, other]))
            for other in others
            if not state.in_hollow(other, self.container)
        )
        known = state.pressed and state.rests(self.object, self.container) and held <= HELD_BY_OTHERS * weight
        return True if known else None


@dataclass(frozen=True)
class Supports(Predicate):
    """One body carries another, directly or through others, each `On` the next.

    Attributes:
        carrier: The lower one.
        object: What it carries.
    """

    carrier: str
    object: str

    def told(self, state: State) -> bool | None:
        """See the class."""
        return self._reaches(self.object, state, frozenset())

    def _reaches(self, name: str, state: State, passed: frozenset[str]) -> bool | None:
        """Whether what carries a body is, or is carried by, the carrier."""
        if name == self.carrier:
            return True
        lower = [b for a, b in {*state.pushes, *state.doubted} if a == name and b not in passed]
        return _any(
            _both(On(name, each).told(state), lambda each=each: self._reaches(each, state, passed | {name}))
            for each in lower
        )


@dataclass(frozen=True)
class Clear(Predicate):
    """A body carries nothing and has nothing in its hollow.

    Attributes:
        object: The body.
    """

    object: str

    def told(self, state: State) -> bool | None:
        """See the class."""
        above = [a for a, b in {*state.pushes, *state.doubted} if b == self.object]
        inside = (
            In(other, self.object).told(state) for other in state.apart(self.object) if other in state.weights
        )
        burdened = _any((*(On(each, self.object).told(state) for each in above), *inside))
        return None if burdened is None else not burdened


@dataclass(frozen=True)
class Stable(Predicate):
    """A body stays where it is: at rest, with its weight on what is at rest, too.

    Of a scene that is what statics says of it. A world's contact forces have to give most of its weight
    upwards: what a gripper holds by friction is not stable. None where forces were never computed.

    Attributes:
        object: The body.
    """

    object: str

    def told(self, state: State) -> bool | None:
        """See the class."""
        if self.object not in state.weights:
            return state.rests(self.object)
        if self.object in state.fallen or not state.rests(self.object):
            return False
        if state.up is None or not state.pressed or any(a == self.object for a, _ in state.doubted):
            return None
        lifts = {b: state.lift(a, b) for a, b in state.pushes if a == self.object}
        loads = sum(-lift for lift in lifts.values() if lift < 0)
        carriers = [name for name, lift in lifts.items() if lift > 0]
        borne = sum(lifts[name] for name in carriers) - loads >= STEADY * state.weights[self.object]
        return borne and all(state.rests(name) for name in carriers)


def _any(answers: Iterable[bool | None]) -> bool | None:
    """Whether one of some answers is True; None where one may be."""
    unknown = False
    for answer in answers:
        if answer:
            return True
        unknown |= answer is None
    return None if unknown else False


def _both(first: bool | None, second: Callable[[], bool | None]) -> bool | None:
    """Whether two answers are True; the second is only asked where it matters."""
    if first is False:
        return False
    other = second()
    return False if other is False else None if first is None or other is None else True
