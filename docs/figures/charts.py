"""Charts of the figures, from the tables that the benches wrote: `python docs/figures/charts.py`.

`reliability.svg`: how often steps called sure, likely and a guess disturbed something. `held.svg`: the rows
of the README. Bars are 95 % intervals.
"""

import re
from collections.abc import Iterable
from pathlib import Path

INK, PAPER, SEEN = "#333333", "#ffffff", {"whole": "#3b6fb5", "3 cameras": "#2e7d32", "1 camera": "#c96a1c"}
FOLDER = Path(__file__).parent
WORDS = {"sure": (0, 5), "likely": (5, 30), "guess": (30, 100)}  # risks that a word stands for [%]
LEFT, WIDE, ROW = 235, 335, 24  # [px] of the plot, and a row
STEP = re.compile(
    r"^\| steps called (\w+) that disturb: ([\w ]+), (\d+) \| ([\d.]+) % \[([\d.]+), ([\d.]+)\]", re.M
)
HELD = re.compile(r"^\| (.+?) \| ([\d,]+) of ([\d,]+) \| ([\d.]+)-([\d.]+) % \|", re.M)


def reliability(page: str) -> str:
    """The chart of words, of the text of `benchmarks/truth.md`: a band is the risk that a word stands for."""
    rows = sorted(STEP.findall(page), key=lambda row: (list(WORDS).index(row[0]), list(SEEN).index(row[1])))
    bands = {place: WORDS[row[0]] for place, row in enumerate(rows)}
    told = [
        (f"{word}, {seen} ({count})", SEEN[seen], *map(float, values)) for word, seen, count, *values in rows
    ]
    return _chart(told, bands, "steps that moved something else [%]; grey: the risk that the word stands for")


def held(page: str) -> str:
    """The chart of the README's rows, of its text."""
    told = []
    for name, good, tried, low, high in HELD.findall(page):
        share = 100 * int(good.replace(",", "")) / int(tried.replace(",", ""))
        told.append((re.sub(r"\[(.*?)\]\(.*?\)", r"\1", name), SEEN["whole"], share, float(low), float(high)))
    return _chart(told, {}, "share [%]")


def _chart(
    rows: Iterable[tuple[str, str, float, float, float]], bands: dict[int, tuple[int, int]], x: str
) -> str:
    """An SVG of a row for each share, low and high end of its interval [%]."""
    parts, y = list[str](), 18
    for place, (name, colour, share, low, high) in enumerate(rows):
        y = 18 + ROW * place
        first, last, at, *band = (
            LEFT + WIDE * value / 100 for value in (low, high, share, *bands.get(place, ()))
        )
        if band:
            size = f'y="{y - 9}" width="{band[1] - band[0]:.0f}" height="18"'
            parts.append(f'<rect x="{band[0]:.0f}" {size} fill="#e3e3e3"/>')
        parts.append(f'<text x="{LEFT - 10}" y="{y + 4}" text-anchor="end">{name.replace("&", "and")}</text>')
        parts.append(
            f'<line x1="{first:.0f}" x2="{last:.0f}" y1="{y}" y2="{y}" stroke="{colour}" stroke-width="2.5"/>'
        )
        parts.append(f'<circle cx="{at:.0f}" cy="{y}" r="4.5" fill="{colour}"/>')
    for value in range(0, 101, 20):
        at = LEFT + WIDE * value / 100
        parts.append(
            f'<line x1="{at:.0f}" x2="{at:.0f}" y1="6" y2="{y + 14}" stroke="{INK}" stroke-width="0.3"/>'
        )
        parts.append(f'<text x="{at:.0f}" y="{y + 28}" text-anchor="middle">{value}</text>')
    parts.append(f'<text x="590" y="{y + 48}" text-anchor="end">{x}</text>')
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 600 {y + 58}"'
    paper = f'<rect width="600" height="{y + 58}" fill="{PAPER}"/>'
    return "\n".join(
        [f'{head} fill="{INK}" font-family="sans-serif" font-size="12">', paper, *parts, "</svg>\n"]
    )


if __name__ == "__main__":
    root = FOLDER.parents[1]
    truth, readme = (root / name for name in ("benchmarks/truth.md", "README.md"))
    (FOLDER / "reliability.svg").write_text(reliability(truth.read_text(encoding="utf-8")), encoding="utf-8")
    (FOLDER / "held.svg").write_text(held(readme.read_text(encoding="utf-8")), encoding="utf-8")
