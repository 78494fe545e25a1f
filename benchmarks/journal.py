"""The journal of a bench of hours: what was played with today's behaviour counts when it goes on."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from topple.benchmarks.behaviour import BEHAVIOUR, MASKS, PLAYS_LIKE, REARRANGING
from topple.benchmarks.episodes import FORMAT, Ending, Episode
from topple.planner.formats.json_lines import JsonLines
from topple.topology.errors import InvalidInput

START = json.dumps({"format": FORMAT})[:-1]
"""How a line begins."""


class Journal(JsonLines):
    """Endings of episodes; each tells which version of behaviour it is of: today's, or one like it, counts.

    Args:
        path: The file; see `JsonLines`.

    Attributes:
        entries: Those that count.
        stale: How many do not.
    """

    def __init__(self, path: Path) -> None:
        self.stale = 0
        self.entries: list[Mapping[str, Any]] = []
        super().__init__(path, "journal of a bench", START)

    def __enter__(self) -> "Journal":
        return self

    def _take(self, entry: Any) -> None:
        if not isinstance(entry, dict) or entry.get("format") != FORMAT:
            raise InvalidInput(f"it is no result, expected {START}, ...}}")
        if entry.get("behaviour") not in {BEHAVIOUR, *PLAYS_LIKE}:
            self.stale += 1
            return
        wanted = _versions(Ending.from_json(entry).episode)
        if any(entry.get(part) != version for part, version in wanted.items()):
            self.stale += 1
            return
        self.entries.append(entry)

    def add(self, entry: Mapping[str, Any]) -> None:
        """Append an entry of today's behaviour; see `JsonLines.add`."""
        kept = {**entry, "behaviour": BEHAVIOUR, **_versions(Ending.from_json(entry).episode)}
        super().add(kept)
        self.entries.append(kept)


def _versions(episode: Episode) -> dict[str, int]:
    """Versions of parts of topple that an episode asks, beside that of the whole."""
    parts: dict[str, int] = {}
    if episode.scenario in REARRANGING:
        parts["rearranging"] = REARRANGING[episode.scenario]
    if episode.mask_noise > 0.0:
        parts["masks"] = MASKS
    return parts
