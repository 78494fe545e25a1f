"""The table of the README, from the tables that the benches wrote: `python docs/figures/table.py`.

Brackets are Wilson's 95 % intervals.
"""

import re
from pathlib import Path

from topple.benchmarks.scores import share_interval

ROOT = Path(__file__).resolve().parents[2]
MARKS = re.compile(r"(<!-- figures: begin -->\n).*?(<!-- figures: end -->)", re.DOTALL)
TWO = r" \| ([\d,]+) \| ([\d,]+)"
ROWS = (
    (
        "towers of [others](docs/results.md#does-it-stand) judged right",
        "towers",
        "true centres of mass" + TWO,
    ),
    ("LIBERO: falling objects found", "libero", "recall of what moves within 1 s" + TWO),
    ("compas-cra: assemblies judged right", "assemblies", "(?:equilibrium says|without one block)" + TWO),
    (
        "published [can shelves](docs/results.md#what-stands-before), ordered right",
        "cans",
        "stands before them, and nothing else" + TWO,
    ),
    ("[fresh piles](docs/fresh-seeds.md), target freed", "run", r"\| `pile` [^|]*\| ()(\d+ of \d+)"),
)
"""Name of a row, the bench that counts it, and the row of its table: tried and held."""


def readme(text: str) -> str:
    """The README with its table written anew."""
    pages = "".join(
        (ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("results.md", "fresh-seeds.md")
    )
    lines = ["| | count | 95 % interval | `topple bench` |", "| --- | ---: | ---: | --- |"]
    for what, bench, pattern in ROWS:
        counts = [
            (held.partition(" of ")[2], held.partition(" of ")[0]) if " of " in held else (tried, held)
            for tried, held in re.findall(pattern, pages)
        ]
        tried, held = (sum(int(one[k].replace(",", "")) for one in counts) for k in (0, 1))
        low, high = (f"{share:.3g}" for share in share_interval(held, tried))
        lines.append(f"| {what} | {held:,} of {tried:,} | {low}-{high} % | `{bench}` |")
    return MARKS.sub(lambda found: found[1] + "\n".join(lines) + "\n" + found[2], text)


if __name__ == "__main__":
    page = ROOT / "README.md"
    page.write_text(readme(page.read_text(encoding="utf-8")), encoding="utf-8")
