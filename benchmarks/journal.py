"""Results kept line by line, so that a bench of hours may be stopped and goes on."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from topple.benchmarks.behaviour import BEHAVIOUR
from topple.topology.errors import InvalidInput

FORMAT = "topple.episode"


class Journal:
    """A file of JSON lines; each tells which version of behaviour it is of, and only today's count.

    Args:
        path: The file; it is made where it is not there.

    Raises:
        InvalidInput: The file cannot be written to, or is something else.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.stale = 0
        self.entries: list[Mapping[str, Any]] = []
        try:
            text = path.read_text(encoding="utf-8") if path.exists() else ""
            self._read(text)
            with path.open("a", encoding="utf-8") as file:
                if text and not text.endswith("\n"):  # the last line was cut off: the next starts afresh
                    file.write("\n")
        except (OSError, UnicodeDecodeError) as error:
            raise InvalidInput(f"{path}: cannot keep results there ({error}): give another file") from error

    def _read(self, text: str) -> None:
        for line in text.splitlines():
            try:
                entry: Any = json.loads(line)
            except json.JSONDecodeError:
                continue  # cut off when the bench was killed; what it stood for is played again
            if not isinstance(entry, dict) or entry.get("format") != FORMAT:
                raise InvalidInput(f"{self.path}: is no journal of a bench: give another file")
            if entry.get("behaviour") == BEHAVIOUR:
                self.entries.append(entry)
            else:
                self.stale += 1

    def add(self, entry: Mapping[str, Any]) -> None:
        """Append an entry, at once and whole."""
        kept = {**entry, "behaviour": BEHAVIOUR}
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(kept) + "\n")
        self.entries.append(kept)
