"""Results kept line by line, so that a bench of hours may be stopped and goes on."""

import ast
import hashlib
import json
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from topple.benchmarks.episodes import IDEAL, TOPPLE
from topple.topology.errors import InvalidInput

RULE, FRAME = "rule of thumb", "real frame"
"""Kinds of episodes beside those that topple decides, and ideal lifts."""

PACKAGES = ("topple.topology", "topple.robots", "topple.planner")

ASIDE = ("planner/report/", "planner/cli/", "planner/export/", "planner/verify/", "benchmarks/")
"""What draws, prints, hands on, checks afterwards or counts: no episode goes otherwise for it."""

PLAYED = {
    TOPPLE: ("episodes",),
    IDEAL: ("episodes", "possible"),
    RULE: ("episodes", "guesses", "rules"),
    FRAME: ("episodes", "frames", "recorded"),
}
"""What of the bench decides all the same how an episode goes, by its kind."""


class Journal:
    """A file of JSON lines; each tells which code it came from, and only those of today's code count.

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
            if not isinstance(entry, dict) or "code" not in entry:
                raise InvalidInput(f"{self.path}: is no journal of a bench: give another file")
            if entry["code"] == code(_kind(entry)):
                self.entries.append(entry)
            else:
                self.stale += 1

    def add(self, entry: Mapping[str, Any]) -> None:
        """Append an entry, at once and whole."""
        kept = {**entry, "code": code(_kind(entry))}
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(kept) + "\n")
        self.entries.append(kept)


def _kind(entry: Mapping[str, Any]) -> str:
    """Which of `PLAYED` the episode of an entry is."""
    episode = entry.get("episode", {})
    if episode.get("folder"):
        return FRAME
    rule = episode.get("rule", TOPPLE)
    return rule if rule in PLAYED else RULE


@cache
def code(kind: str) -> str:
    """Fingerprint of what episodes of a kind go through: results of other code are not mixed with today's.

    Comments, docstrings and what only shows results do not count.

    Args:
        kind: One of `PLAYED`.
    """
    played = {f"benchmarks/{name}.py" for name in PLAYED[kind]}
    digest = hashlib.sha256()
    for package in PACKAGES:
        folder = Path(str(import_module(package).__file__)).parent
        for path in sorted(folder.rglob("*.py")):
            place = f"{folder.name}/{path.relative_to(folder).as_posix()}"
            if place in played or not place.startswith(ASIDE):
                digest.update(behaviour(path.read_text(encoding="utf-8")).encode())
    return digest.hexdigest()[:16]


def behaviour(source: str) -> str:
    """A module's text without what does nothing: comments, docstrings, blanks.

    Args:
        source: Python.
    """
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            texts = [line for line in node.body if _is_text(line)]
            node.body = [line for line in node.body if line not in texts]
    return ast.dump(tree)


def _is_text(line: ast.stmt) -> bool:
    return (
        isinstance(line, ast.Expr)
        and isinstance(line.value, ast.Constant)
        and isinstance(line.value.value, str)
    )
