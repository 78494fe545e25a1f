"""Turn what `topple bench --json` printed into Markdown tables, as the README shows them.

Usage: topple bench --quick --json > figures.jsonl; python benchmarks/table.py figures.jsonl
"""

import json
import sys
from pathlib import Path
from typing import Any


def table(document: dict[str, Any]) -> str:
    """One bench as a heading, the machine and a Markdown table."""
    machine = document["machine"]
    size = " (quick)" if document["quick"] else ""
    lines = [
        f"**{document['bench']}**{size}, {machine['processor']}, {machine['cores']} cores, "
        f"Python {machine['python']}",
        "",
        "| what | value | baseline | its value | ratio | bar | |",
        "| --- | ---: | --- | ---: | ---: | --- | --- |",
    ]
    return "\n".join([*lines, *(_line(row) for row in document["rows"])])


def _line(row: dict[str, Any]) -> str:
    value = _figure(row["value"], row["unit"])
    if "interval" in row:
        value += " [{:.3g}, {:.3g}]".format(*row["interval"])
    theirs = "" if row["baseline_value"] is None else _figure(row["baseline_value"], row["unit"])
    ratio = "" if row["ratio"] is None else f"{row['ratio']:.3g}x"
    verdict = {None: "", True: "ok", False: "missed"}[row["ok"]]
    cells = (row["what"], value, row["baseline"] or "", theirs, ratio, row["bar"] or "", verdict)
    return f"| {' | '.join(cells)} |"


def _figure(value: float, unit: str) -> str:
    text = f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    return f"{text} {unit}".rstrip()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python benchmarks/table.py FILE")
    documents = Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()
    print("\n\n".join(table(json.loads(document)) for document in documents))
