"""A picture for people, with masks that say what is where in it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from topple.topology.arrays import IntArray
from topple.topology.values import ByValue


@dataclass(frozen=True, eq=False)
class Photo(ByValue):
    """A picture for people, and what is where in it.

    Attributes:
        rgb: (H, W, 3) uint8.
        label: (H, W) which thing a pixel shows, 0 where none has a name.
        names: Label -> name.
    """

    rgb: Any
    label: IntArray
    names: Mapping[int, str] = field(default_factory=dict[int, str])
