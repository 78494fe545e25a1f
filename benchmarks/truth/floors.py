"""Floors: figures of truth that no change may fall below; they rise and never fall."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import date
from pathlib import Path

import msgspec

from topple.benchmarks.row import Row
from topple.benchmarks.truth.counts import FIGURES
from topple.topology.base.errors import InvalidInput

POOL = "pool"
"""All generators of the pool together."""


@dataclass(frozen=True)
class Floor:
    """What a figure must not fall below.

    Attributes:
        set: Of the scenes.
        view: Of them.
        figure: Its name.
        value: When it was raised.
        chance: What jitter alone moved it by.
        floor: Value less one and a half times the chance; of a figure of which less is better, more.
        raised: When, and by which commit.
    """

    set: str
    view: str
    figure: str
    value: float
    chance: float
    floor: float
    raised: str


MARGIN = 1.5
"""Times the most that eight kinds of jitter moved a figure by: the next kind moves it by a little more."""

_BETTER = {figure.what: figure.better for figure in FIGURES}


@dataclass(frozen=True)
class Floors:
    """The floors in a file.

    Attributes:
        floors: By set, view and figure.
    """

    floors: Mapping[tuple[str, str, str], Floor]

    @staticmethod
    def read(path: Path) -> "Floors":
        """Read a file; none has no floors.

        Raises:
            InvalidInput: It is something else.
        """
        if not path.exists():
            return Floors({})
        try:
            document = json.loads(path.read_text(encoding="utf-8"))
            entries = msgspec.convert(document["floors"], list[Floor])
        except (ValueError, KeyError, TypeError) as error:
            raise InvalidInput(f"{path}: holds no floors of truth ({error})") from error
        return Floors({(entry.set, entry.view, entry.figure): entry for entry in entries})

    def raised(
        self,
        values: Mapping[tuple[str, str, str], float],
        chance: Mapping[tuple[str, str, str], float],
        commit: str,
    ) -> "Floors":
        """Raised to today's figures where these are better; none falls.

        Args:
            values: Figures, better the more they are.
            chance: What jitter moves each by; that of the pool's scenes for recorded ones.
            commit: That has them.
        """
        found = dict(self.floors)
        for key, value in values.items():
            better = _BETTER[key[2]]
            moved = chance.get(key, chance.get((POOL, *key[1:]), 0.0))
            low = value - MARGIN * moved
            low = max(low, 0.0) if better > 0 else low  # no share is below nothing
            if key not in found or low > better * found[key].floor:
                said = f"{date.today().isoformat()} {commit}"
                numbers = (round(better * value, 4), round(moved, 4), round(better * low, 4))
                found[key] = Floor(*key, *numbers, said)
        return Floors(found)

    def rows(self, values: Mapping[tuple[str, str, str], float]) -> list[Row]:
        """Figures against their floors."""
        told: list[Row] = []
        for key, value in values.items():
            if (floor := self.floors.get(key)) is not None:
                better = _BETTER[key[2]]
                bar = f"{'>=' if better > 0 else '<='} {floor.floor:.4f}"
                what = f"{key[2]}: {key[0]}, {key[1]}, the 60"
                shown, since = round(better * value + 0.0, 4), floor.raised.split()[0]
                told.append(Row(what, shown, "", since, floor.value, bar=bar))
        return told

    def text(self) -> str:
        """The file, a floor a line."""
        lines = ",\n".join(json.dumps(asdict(entry)) for _, entry in sorted(self.floors.items()))
        return '{"format": "topple.truth", "format_version": 1, "floors": [\n' + lines + "\n]}\n"
