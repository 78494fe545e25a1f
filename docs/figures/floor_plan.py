"""The floor plan of CONTRIBUTING: every room of the three layers, with the first sentence of its docstring.

python docs/figures/floor_plan.py
"""

import ast
import sys
from html import escape
from pathlib import Path
from textwrap import wrap

ROOT = Path(__file__).resolve().parents[2]
LAYERS = {"topology": "what is where", "robots": "what can act", "planner": "what to do"}
WIDE, GAP, ROW, LINE = 372, 44, 12, 16
STYLE = """<style>text { font-family: system-ui, sans-serif; fill: #1c1e21; }
.room { fill: #fff; stroke: #c9cdd2; } .name { font-size: 14px; font-weight: 600; }
.told { font-size: 12px; fill: #5d6167; }</style>"""


def summary(room: Path) -> str:
    """The first sentence of a room's docstring."""
    told = ast.get_docstring(ast.parse((room / "__init__.py").read_text(encoding="utf-8"))) or ""
    return told.split("\n\n")[0].split(". ")[0].replace("\n", " ").rstrip(".").replace("`", "")


def column(layer: str, purpose: str, x: int) -> tuple[str, int]:
    """A layer with its rooms below each other; the SVG and its height."""
    y, parts = 70, []
    for room in sorted(path.parent for path in (ROOT / layer).glob("*/__init__.py")):
        lines = wrap(summary(room), 50)
        height = 30 + LINE * len(lines)
        parts.append(
            f"<rect x='{x + 12}' y='{y}' width='{WIDE - 24}' height='{height}' rx='5' class='room'/>"
            f"<text x='{x + 24}' y='{y + 20}' class='name'>{room.name}/</text>"
        )
        for number, line in enumerate(lines):
            parts.append(
                f"<text x='{x + 24}' y='{y + 38 + LINE * number}' class='told'>{escape(line)}</text>"
            )
        y += height + ROW
    head = (
        f"<text x='{x + 16}' y='36' font-size='20' font-weight='700' fill='#1c1e21'>{layer}/</text>"
        f"<text x='{x + 16}' y='57' font-size='13' fill='#5d6167'>{purpose}</text>"
    )
    return head + "".join(parts), y


def main() -> None:
    """Draw the layers beside each other; arrows say what may import what."""
    columns = [
        column(layer, purpose, number * (WIDE + GAP))
        for number, (layer, purpose) in enumerate(LAYERS.items())
    ]
    height, width = max(high for _, high in columns), len(columns) * (WIDE + GAP) - GAP
    body = ""
    for number, (drawn, _) in enumerate(columns):
        x = number * (WIDE + GAP)
        body += f"<rect x='{x}' y='0' width='{WIDE}' height='{height}' rx='8' fill='#eef1f4'/>{drawn}"
        if number:
            body += (
                f"<path d='M{x - 4} 34 H{x - GAP + 12}' stroke='#c0392b' stroke-width='3'/>"
                f"<path d='M{x - GAP + 3} 34 l13 -7 v14 z' fill='#c0392b'/>"
            )
    place = Path(__file__).with_suffix(".svg")
    place.write_text(
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}'>{STYLE}{body}</svg>\n",
        encoding="utf-8",
    )
    sys.stdout.write(f"{place.name}: {width} x {height}\n")


if __name__ == "__main__":
    main()
