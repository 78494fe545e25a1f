"""Results kept line by line, so that a bench of hours may be stopped and goes on."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from topple.benchmarks.behaviour import BEHAVIOUR
from topple.benchmarks.episodes import FORMAT, Ending
from topple.topology.errors import InvalidInput
from topple.topology.io.strict_json import read_json

START = json.dumps({"format": FORMAT})[:-1]
"""How a line begins: what is no JSON and begins so was cut off, all else is somebody else's."""


class Journal:
    """A file of JSON lines; each tells which version of behaviour it is of, and only today's count.

    Args:
        path: The file; it is made where it is not there.

    Raises:
        InvalidInput: The file cannot be written to, or is something else; names the line.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.stale = 0
        self.entries: list[Mapping[str, Any]] = []
        if path.exists() and not path.is_file():  # a pipe would be waited for
            raise InvalidInput(f"{path}: cannot keep results there (no file): give another file")
        try:
            text = path.read_text(encoding="utf-8") if path.exists() else ""
            for number, line in enumerate(text.split("\n"), start=1):
                if line.strip():
                    self._take(line, number)
            with path.open("a", encoding="utf-8") as file:
                if text and not text.endswith("\n"):  # the last line was cut off: the next starts afresh
                    file.write("\n")
        except (OSError, UnicodeDecodeError) as error:
            raise InvalidInput(f"{path}: cannot keep results there ({error}): give another file") from error

    def _take(self, line: str, number: int) -> None:
        """Take in a line; one that was cut off when a bench was killed stands for what is played again."""
        try:
            entry: Any = read_json(line, "the line")
        except InvalidInput as error:
            if line.startswith(START[: len(line)]) and not line.rstrip().endswith("}"):
                return
            raise self._refusal(number, str(error)) from error
        if not isinstance(entry, dict) or entry.get("format") != FORMAT:
            raise self._refusal(number, f"it is no result, expected {START}, ...}}")
        if entry.get("behaviour") != BEHAVIOUR:
            self.stale += 1
            return
        try:
            Ending.from_json(entry)
        except InvalidInput as error:
            raise self._refusal(number, str(error)) from error
        self.entries.append(entry)

    def _refusal(self, number: int, reason: str) -> InvalidInput:
        return InvalidInput(
            f"{self.path}: line {number} is no journal of a bench ({reason}): give another file, or take the "
            "line out"
        )

    def add(self, entry: Mapping[str, Any]) -> None:
        """Append an entry, at once and whole."""
        kept = {**entry, "behaviour": BEHAVIOUR}
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(kept) + "\n")
        self.entries.append(kept)
