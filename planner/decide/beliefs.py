"""What earlier looks made of a scene: one look errs more than several at the same things."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from statistics import fmean

from topple.planner.decide.disturbance import Pair
from topple.topology.base.values import ByValue


@dataclass(frozen=True, eq=False)
class Beliefs(ByValue):
    """Kept from look to look of a scene that is taken apart.

    Attributes:
        chances: Pair -> the chances that looks so far gave, for objects that stayed where they were.
        alone: Objects that were put down clear of all others.
        measured: (first, then): lifting `then` was seen to move `first`, and both are as they were.
    """

    chances: Mapping[Pair, tuple[float, ...]] = field(default_factory=dict[Pair, tuple[float, ...]])
    alone: frozenset[str] = frozenset()
    measured: frozenset[Pair] = frozenset()

    def weigh(self, found: Mapping[Pair, float], edges: Collection[Pair]) -> dict[Pair, float]:
        """Average the chances of one more look with those believed.

        Args:
            found: Pair -> its chance by this look alone.
            edges: Pairs that this look found a dependency of; of the others one may be overlooked.

        Returns:
            Pair -> the mean of all looks; 0 where nothing was found of what was put down clear of all others.
        """
        return {
            pair: 0.0
            if pair not in edges and not self.alone.isdisjoint(pair)
            else fmean((*self.chances.get(pair, ()), now))
            for pair, now in found.items()
        }

    def after(
        self, found: Mapping[Pair, float], stirred: Collection[str], put_down: Collection[str]
    ) -> "Beliefs":
        """Beliefs after an action.

        Args:
            found: Pair -> its chance by the look before the action.
            stirred: Objects that are not where they were: what was believed of them is forgotten.
            put_down: Those of them that were put down clear of all others.
        """
        gone = set(stirred)
        chances = {
            pair: (*self.chances.get(pair, ()), chance)
            for pair, chance in found.items()
            if gone.isdisjoint(pair)
        }
        return replace(self, chances=chances, alone=self.alone - gone | frozenset(put_down))

    def learn(self, changed: Collection[str], moved: Collection[str], lifted: str) -> "Beliefs":
        """Beliefs after a lift was watched.

        Args:
            changed: Objects that are not where they were: what was measured of them is forgotten.
            moved: What was seen to move.
            lifted: What was put back then.
        """
        kept = (pair for pair in self.measured if not set(changed).intersection(pair))
        return replace(self, measured=frozenset([*kept, *((other, lifted) for other in moved)]))
