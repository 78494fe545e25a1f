"""The journal of a bench of hours: each line says which commit played it, and by which code it counts."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from topple.benchmarks.episodes import FORMAT, Ending
from topple.benchmarks.versions import code_key, commit_now
from topple.planner.formats.json_lines import JsonLines
from topple.topology.base.errors import InvalidInput

START = json.dumps({"format": FORMAT})[:-1]
"""How a line begins."""


class Journal(JsonLines):
    """Endings of episodes; those count that one and the same code played.

    Args:
        path: The file; see `JsonLines`.
        last: Whether what counts is what the code of the last line played, not what today's did.

    Attributes:
        lines: All of them.
    """

    def __init__(self, path: Path, *, last: bool = False) -> None:
        self.lines: list[Mapping[str, Any]] = []
        self._last, self._code = last, code_key()
        super().__init__(path, "journal of a bench", START)

    def __enter__(self) -> "Journal":
        return self

    @property
    def entries(self) -> list[Mapping[str, Any]]:
        """Those that count."""
        code = self.lines[-1].get("code") if self._last and self.lines else self._code
        return [entry for entry in self.lines if entry.get("code") == code]

    @property
    def stale(self) -> int:
        """How many do not."""
        return len(self.lines) - len(self.entries)

    def _take(self, entry: Any) -> None:
        if not isinstance(entry, dict) or entry.get("format") != FORMAT:
            raise InvalidInput(f"it is no result, expected {START}, ...}}")
        Ending.from_json(entry)  # refused here, by the number of its line
        self.lines.append(entry)

    def add(self, entry: Mapping[str, Any]) -> None:
        """Append an entry of today's code; see `JsonLines.add`."""
        kept = {**entry, "commit": commit_now(), "code": self._code}
        super().add(kept)
        self.lines.append(kept)
