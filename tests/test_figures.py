"""Figures in pages: each stands in the rows of a bench or the file of numbers that its line names.

A mark is `<!--FILE: ROW; ROW-->`: a page of `benchmarks/` or a path, and words of rows, or keys of its JSON.
"""

import json
import re
import runpy
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

NUMBER = re.compile(r"(?<![\w.])\d[\d,]*(?:\.\d+)?")


@pytest.mark.parametrize(("chart", "page"), [("reliability", "benchmarks/truth.md"), ("held", "README.md")])
def test_charts_show_the_tables(chart, page):
    draw = runpy.run_path(str(ROOT / "docs" / "figures" / "charts.py"))[chart]
    drawn = (ROOT / "docs" / "figures" / f"{chart}.svg").read_text(encoding="utf-8")
    assert drawn == draw((ROOT / page).read_text(encoding="utf-8")) and drawn.count("<circle") >= 5


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


def of_episodes(*policies: list[list[float]]) -> Iterator[float]:
    """Numbers of episodes of (return, steps, disturbed, reached): means, sums, and how many were clean.

    Of two policies also how many one alone cleared, and the difference of returns with its interval.
    """
    told = np.asarray(policies, dtype=np.float64)
    clean = (told[..., 2] == 0) & (told[..., 3] == 1)
    yield from (told.shape[1], *clean.sum(axis=1), *told.mean(axis=1).ravel(), *told.sum(axis=1).ravel())
    if len(told) == 2:
        more = told[0, :, 0] - told[1, :, 0]
        drawn = more[np.random.default_rng(0).integers(0, len(more), (10_000, len(more)))].mean(axis=1)
        yield from (*(clean & ~clean[::-1]).sum(axis=1), more.mean(), *np.quantile(drawn, (0.025, 0.975)))


def known(mark: re.Match[str]) -> list[float]:
    place = ROOT / mark[1] if "/" in mark[1] else ROOT / "benchmarks" / mark[1]
    text = place.read_text(encoding="utf-8")
    if place.suffix == ".json":
        told = [json.loads(text)[key] for key in mark[2].split("; ")]
        return list(np.abs(told[0])) if np.ndim(told[0]) == 1 else list(of_episodes(*told))
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
def test_figures_stand_in_the_rows_that_their_marks_name(page):
    for line in page.read_text(encoding="utf-8").splitlines():
        if mark := MARK.search(line):
            among = known(mark)
            bare = bared(line)
            for held, tried in re.findall(r"(\d+) of (\d+)", bare):
                among += share_interval(int(held), int(tried))
            wrong = [figure for figure in numbers(bare) if not stands(figure, among)]
            assert not wrong, f"{wrong} of {line!r} are not in {mark[0]}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_share_has_a_mark_or_comes_from_a_command(page):
    lines = MADE.sub("", page.read_text(encoding="utf-8")).splitlines()
    bare = [line for line in lines if SHARE.search(bared(line)) and not MARK.search(line)]
    assert not bare, "say from where: <!--run.md: words of the row-->"
