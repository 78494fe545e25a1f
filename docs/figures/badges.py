"""The badges of the README, from what pyproject.toml states; a test holds them to that.

python docs/figures/badges.py
"""

import re
import sys
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HIGH, LETTER, PAD, GAP = 20, 6.6, 8, 6
STYLE = (
    "<style>text { font: 11px Verdana, 'DejaVu Sans', sans-serif; fill: #fff; text-anchor: middle; }</style>"
)


def badges() -> dict[str, str]:
    """What each badge is about -> what it says."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    pythons = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', text)
    licence = re.findall(r'^license = "(\w+)"', text, re.MULTILINE)
    (status,) = re.findall(r'"Development Status :: \d - (\w+)"', text)
    types = (
        "checked, shipped"
        if '"Typing :: Typed"' in text and 'typeCheckingMode = "strict"' in text
        else "none"
    )
    return {"python": " | ".join(pythons), "licence": licence[0], "status": status.lower(), "types": types}


def drawn(said: dict[str, str]) -> str:
    """The badges in a row, as SVG."""
    parts, x = "", 0.0
    for about, words in said.items():
        left, right = (LETTER * len(text) + 2 * PAD for text in (about, words))
        parts += (
            f"<rect x='{x:.0f}' width='{left:.0f}' height='{HIGH}' fill='#4a4f57'/>"
            f"<rect x='{x + left:.0f}' width='{right:.0f}' height='{HIGH}' fill='#1f5fbf'/>"
            f"<text x='{x + left / 2:.0f}' y='14'>{escape(about)}</text>"
            f"<text x='{x + left + right / 2:.0f}' y='14'>{escape(words)}</text>"
        )
        x += left + right + GAP
    width = x - GAP
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' width='{width:.0f}' height='{HIGH}' "
        f"viewBox='0 0 {width:.0f} {HIGH}'>{STYLE}{parts}</svg>\n"
    )


def main() -> None:
    """Draw them."""
    place = Path(__file__).with_suffix(".svg")
    place.write_text(drawn(badges()), encoding="utf-8")
    sys.stdout.write(f"{place.name}: {badges()}\n")


if __name__ == "__main__":
    main()
