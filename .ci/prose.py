"""How the pages read: words by hand, sentences that are too long, and words that read as if translated.

    python .ci/prose.py

Counts README, docs (but what is generated), benchmarks' pages and the pages at the root, outside code and
addresses. Exit 1 where a figure passes its bar, or where a sentence has a phrase of the list.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BARS = {"README": 400, "docs": 15000, "all": 26000, "page": 800, "what": 2.0, "long": 2.5}
LONG = 28  # words of a sentence
PHRASES = re.compile(
    r"\bshall\b|\bthings?\b|\bso far as\b|\bby now\b|\bstands? nowhere\b|\blet go what\b", re.IGNORECASE
)
BLOCKS = re.compile(r"```.*?```", re.DOTALL)
UNREAD = re.compile(r"<[^>]+>|\]\([^)]*\)|[|`#*_-]")
WORD = re.compile(r"[A-Za-z][A-Za-z'’-]*")


def read(page: Path) -> str:
    """The text of a page, without blocks of code, marks and addresses."""
    return UNREAD.sub(" ", BLOCKS.sub(" ", page.read_text(encoding="utf-8")))


def offences(page: Path) -> list[str]:
    """Where a page has a phrase of the list; rows of tables are said by the benches, old changes stay."""
    text = BLOCKS.sub(lambda block: "\n" * block[0].count("\n"), page.read_text(encoding="utf-8"))
    lines = enumerate(text.partition("## [0.1.0]")[0].splitlines(), start=1)
    said = [(number, re.sub(r"`[^`]*`|<[^>]+>|\]\([^)]*\)", " ", line)) for number, line in lines]
    return [f"{page.relative_to(ROOT)}:{number}: {match[0]!r}" for number, line in said
            if page.parent.name != "benchmarks" or not line.startswith("|")
            for match in PHRASES.finditer(line)]  # fmt: skip


def main() -> int:
    """Print the figures and what is wrong; 1 where anything is."""
    docs = [page for page in sorted((ROOT / "docs").rglob("*.md")) if "api" not in page.parts]
    others = [*sorted((ROOT / "benchmarks").rglob("*.md")), *sorted(ROOT.glob("*.md"))]
    counts = {page: len(WORD.findall(read(page))) for page in [*docs, *others]}
    words = [word.lower() for page in docs for word in WORD.findall(read(page))]
    sentences = [each for page in docs for each in re.split(r"(?<=[.!?])\s+", read(page))]
    found = {
        "README": counts[ROOT / "README.md"],
        "docs": sum(counts[page] for page in docs),
        "all": sum(counts.values()),
        "page": max(counts[page] for page in docs),
        "what": 1000 * words.count("what") / len(words),
        "long": 1000 * sum(len(each.split()) > LONG for each in sentences) / len(words),
    }
    for name, value in found.items():
        sys.stdout.write(f"{name:8} {value:8.5g} of {BARS[name]:8.5g}{'  OVER' * (value > BARS[name])}\n")
    wrong = [each for page in [*docs, *others] for each in offences(page)]
    sys.stdout.writelines(f"{each}\n" for each in wrong)
    return int(bool(wrong) or any(value > BARS[name] for name, value in found.items()))


if __name__ == "__main__":
    sys.exit(main())
