"""The curve of examples/11_learn.py: the return of each batch of piles, and of 200 fresh ones, as an SVG.

python docs/figures/learning.py        # from docs/figures/learned.json, which that example wrote
"""

import json
from pathlib import Path

import numpy as np

BLUE, ORANGE, INK, PAPER = "#3b6fb5", "#c96a1c", "#333333", "#ffffff"  # no studio: that needs PyVista
FOLDER = Path(__file__).parent
FONT = 'font-family="sans-serif" font-size="14"'
LEFT, WIDE, ZERO, UNIT = 70, 400, 110, 90  # [px] of the plot; where a return is 0, and per unit of it


def main() -> None:
    """Write learning.svg."""
    told = json.loads((FOLDER / "learned.json").read_text(encoding="utf-8"))
    batches = np.reshape(told["returns"], (-1, 8)).mean(axis=1)
    at = LEFT + WIDE * (np.arange(len(batches)) + 0.5) / len(batches)
    curve = " ".join(f"{x:.0f},{ZERO - UNIT * y:.0f}" for x, y in zip(at, batches, strict=True))
    parts = [f'<rect width="640" height="220" fill="{PAPER}"/>']
    for value in (-1, 0, 1):
        parts.append(_line(ZERO - UNIT * value, INK, "0.4", f"{value}", 40))
    for name, colour, down in (("learned", BLUE, 1), ("highest", ORANGE, 12)):
        mean = float(np.mean([row[0] for row in told[name]]))
        parts.append(
            _line(ZERO - UNIT * mean, colour, "2", f"{name}, fresh: {mean:.2f}", LEFT + WIDE + 6, down)
        )
    parts.append(f'<polyline points="{curve}" fill="none" stroke="{BLUE}" stroke-width="2"/>')
    parts += [
        f'<circle cx="{x:.0f}" cy="{ZERO - UNIT * y:.0f}" r="4"/>' for x, y in zip(at, batches, strict=True)
    ]
    parts.append(f'<text x="{LEFT}" y="216">mean return of each batch of 8 piles, in order</text>')
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 220" fill="{INK}" {FONT}>'
    (FOLDER / "learning.svg").write_text("\n".join([head, *parts, "</svg>\n"]), encoding="utf-8")


def _line(y: float, colour: str, width: str, text: str, x: int, down: int = 5) -> str:
    line = f'<line x1="{LEFT}" x2="{LEFT + WIDE}" y1="{y:.0f}" y2="{y:.0f}" stroke="{colour}"'
    return f'{line} stroke-width="{width}"/><text x="{x}" y="{y + down:.0f}">{text}</text>'


if __name__ == "__main__":
    main()
