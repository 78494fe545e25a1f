"""Figures in pages: each stands in the rows of a bench or the file of numbers that its line names.

A mark is `<!--FILE: ROW; ROW-->`: a page of `benchmarks/` or a path, and words of rows, or a key of its JSON.
"""

import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from topple.benchmarks.scores import share_interval

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
MARK = re.compile(r"<!--(\S+): (.*?)-->")
ENDS = "end of table|arms: end|figures: end"
MADE = re.compile(rf"<!-- (?:table of|arms: begin|figures: begin).*?<!-- (?:{ENDS}) -->|```.*?```", re.DOTALL)
SHARE = re.compile(r"(?<!bar: )(?<![\d.])(?!95 %)[\d.]+ %|\d of \d")
"""A figure that was counted: limits, bars and the 95 % of intervals are said, not counted."""

RECORDS = ("tried.md",)
"""Pages of what was tried and is gone: nothing can count it anew."""

NUMBER = re.compile(r"(?<![\w.])\d[\d,]*(?:\.\d+)?")


def numbers(text: str) -> list[str]:
    return [each.replace(",", "") for each in NUMBER.findall(text)]


def of_rows(rows: list[str]) -> Iterator[float]:
    """Numbers of rows, counts that their shares are of, and sums of their columns with what these leave."""
    columns = [[float((numbers(cell) or ["nan"])[0]) for cell in row.split(" | ")[1:]] for row in rows]
    sums = [sum(column) for column in zip(*columns, strict=False)]
    yield from (*sums, *(abs(a - b) for a in sums for b in sums))
    for row in rows:
        found = [float(each) for each in numbers(row)]
        yield from (*found, *(a * b / 100 for a in found for b in found))


def of_episodes(told: list[list[float]]) -> Iterator[float]:
    """Numbers of episodes of (return, steps, disturbed, reached): means, sums, and how many were clean."""
    columns = np.asarray(told, dtype=np.float64)
    clean = (columns[:, 2] == 0) & (columns[:, 3] == 1)
    yield from (len(told), clean.sum(), *columns.mean(axis=0), *columns.sum(axis=0))


def known(mark: re.Match[str]) -> list[float]:
    place = ROOT / mark[1] if "/" in mark[1] else ROOT / "benchmarks" / mark[1]
    text = place.read_text(encoding="utf-8")
    if place.suffix == ".json":
        return list(of_episodes(json.loads(text)[mark[2]]))
    chosen = [
        [row for row in text.splitlines() if row.startswith("|") and part in row]
        for part in mark[2].split("; ")
    ]
    assert all(chosen), f"{place.name} has no row with every one of {mark[2]!r}"
    return list(of_rows([row for rows in chosen for row in rows]))


def bared(line: str) -> str:
    """A line without marks, code, the addresses of links, and limits."""
    return re.sub(r"<!--.*?-->|`[^`]*`|\]\([^)]*\)|(?:below|above) \S+|\S+ and more", " ", line)


def stands(figure: str, among: list[float]) -> bool:
    """Whether a figure is one of some numbers, rounded as it is."""
    digits = len(figure.partition(".")[2])
    return any(abs(float(figure) - value) <= 0.5001 * 10.0**-digits for value in among)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_figures_stand_in_the_rows_that_their_marks_name(page: Path) -> None:
    for line in page.read_text(encoding="utf-8").splitlines():
        if mark := MARK.search(line):
            among = known(mark)
            bare = bared(line)
            for held, tried in re.findall(r"(\d+) of (\d+)", bare):
                among += share_interval(int(held), int(tried))
            wrong = [figure for figure in numbers(bare) if not stands(figure, among)]
            assert not wrong, f"{wrong} of {line!r} are not in {mark[0]}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_share_has_a_mark_or_comes_from_a_command(page: Path) -> None:
    lines = MADE.sub("", page.read_text(encoding="utf-8")).splitlines()
    bare = [line for line in lines if SHARE.search(bared(line)) and not MARK.search(line)]
    assert page.name in RECORDS or not bare, "say from where: <!--run.md: words of the row-->"
