"""How many seeds of a built-in scene reach the goal with nothing disturbed, as they were counted.

The figures are in `demo_seeds.json`, which `topple bench demo --counts` writes.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypedDict

import msgspec

FILE = Path(__file__).with_name("demo_seeds.json")
FORMAT, FORMAT_VERSION = "topple.demo_seeds", 1

CAMERAS = 3
"""How many cameras look on in a demo and in what was counted, unless told otherwise."""


@dataclass(frozen=True)
class SeedCount:
    """The seeds of a scene that were played.

    Attributes:
        played: Seeds, ascending.
        reached: Those of them that reached the goal with nothing disturbed.
        default: The seed that is played where none is given.
    """

    played: tuple[int, ...]
    reached: tuple[int, ...]
    default: int

    def __str__(self) -> str:
        """In words."""
        first, last = self.played[0], self.played[-1]
        whole = len(self.played) == last - first + 1
        which = f"seeds {first} to {last}" if whole else f"{len(self.played)} seeds from {first} to {last}"
        which = f"seed {first} alone" if first == last else which
        return f"of {which}, {len(self.reached)} reach the goal with nothing disturbed"


def counted_scenes() -> tuple[str, ...]:
    """Names of the scenes that were counted: all that are built in. Asking needs no simulation."""
    return tuple(_counts())


def seed_count(name: str) -> SeedCount | None:
    """Look up the count of a scene.

    Args:
        name: Of the scene.

    Returns:
        The count; None where it was never counted.
    """
    return _counts().get(name)


def default_seed(name: str) -> int:
    """The seed of a scene that is played where none is given: 0 where none was counted.

    Args:
        name: Of the scene.
    """
    count = seed_count(name)
    return 0 if count is None else count.default


def document(counts: Mapping[str, SeedCount], made: Mapping[str, Any]) -> dict[str, Any]:
    """The document that is kept.

    Args:
        counts: By name of the scene.
        made: By what, of which commit.
    """
    kept = {"format": FORMAT, "format_version": FORMAT_VERSION}
    return {**kept, **made, "scenes": msgspec.to_builtins(counts)}


def text(document: Mapping[str, Any]) -> str:
    """The document as JSON, a scene's seeds on one line."""
    lines = json.dumps(document, indent=1).splitlines()
    return _join_numbers(lines) + "\n"


def _join_numbers(lines: Sequence[str]) -> str:
    """Lines of indented JSON with lists of numbers on one line."""
    found: list[str] = []
    for line in lines:
        number = line.strip().rstrip(",").isdigit()
        if found and (number or line.strip().startswith("]")) and "[" in found[-1]:
            found[-1] += line.strip() + (" " if number and line.endswith(",") else "")
        else:
            found.append(line)
    return "\n".join(found)


class _Kept(TypedDict):
    scenes: dict[str, SeedCount]


@cache
def _counts() -> Mapping[str, SeedCount]:
    return msgspec.json.decode(FILE.read_bytes(), type=_Kept)["scenes"]
