"""What goes to stdout: JSON lines, or tables for people."""

import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from topple.planner.cli.arguments import OPTIONS

_OPTIONS = {"max_bytes": "--max-mb"}
"""Keywords of Python whose options are called otherwise."""

_ELSE = re.compile(r",? or pose_source_to_world=\w+")
"""What Python alone can be given."""

_WIDTH = 120  # columns where stdout is no terminal: wide enough that no name is cut


def print_json(document: Mapping[str, Any]) -> None:
    """Print one document as one line of JSON.

    Args:
        document: Plain JSON data; NaN and infinity are refused, since JSON has neither.

    Raises:
        ValueError: If the document holds NaN or infinity.
    """
    plain = not (sys.stdout.encoding or "").lower().startswith("utf")
    sys.stdout.write(json.dumps(document, ensure_ascii=plain, allow_nan=False) + "\n")
    sys.stdout.flush()


def complain(*lines: str) -> None:
    """Say on stderr what is wrong, each thing on one line.

    Args:
        lines: What is wrong, in the words of Python or of the command line; line breaks become blanks.
    """
    for line in lines:
        sys.stderr.write(f"topple: {in_options(' '.join(line.split()))}\n")


def in_options(text: str) -> str:
    """A message of the library as the command line says it: its options in place of keywords of Python."""
    flags = {flag.lstrip("-").replace("-", "_"): flag for flag in OPTIONS} | _OPTIONS

    def option(match: re.Match[str]) -> str:
        value = re.sub(r"[][,']", "", match[2]).removesuffix("True")
        return f"{flags[match[1]]} {value}".rstrip()

    return re.sub(rf"(?<![\w.])({'|'.join(flags)})=(\[[^]]*\]|[^\s,:;)]*)", option, _ELSE.sub("", text))


def print_text(*lines: str) -> None:
    """Print lines as they are; names never count as markup.

    Args:
        lines: The lines.
    """
    for line in lines:
        sys.stdout.write(line + "\n")


def print_table(headings: Sequence[str], rows: Iterable[Sequence[str]], *, right: Sequence[int] = ()) -> None:
    """Print a table.

    Args:
        headings: One per column.
        rows: One text per column each.
        right: Columns aligned to the right: numbers.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for column, heading in enumerate(headings):
        table.add_column(heading, justify="right" if column in right else "left", overflow="fold")
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    width = None if sys.stdout.isatty() else _WIDTH
    Console(file=sys.stdout, width=width, markup=False, highlight=False, emoji=False).print(table)
