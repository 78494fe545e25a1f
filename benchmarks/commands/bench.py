"""`topple bench`: the figures of the README on this machine, each with a baseline beside it."""

import argparse
import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from topple.benchmarks.document import ALONE, BENCHES, CHECKS, bench, options_of
from topple.benchmarks.markdown import markdown_table, replaced_table
from topple.planner.cli.arguments import COMMON, add, add_jobs, count, from_zero, value
from topple.planner.cli.console import complain, print_json, print_table, print_text
from topple.planner.cli.main import DONE
from topple.planner.cli.many import executor_at
from topple.planner.cli.progress import Progress
from topple.topology.base.errors import InvalidInput
from topple.topology.base.files import check_writable, make_folder, write_whole

MISSED = 1
"""Exit code where a figure misses its bar."""

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_WITH_VALUES = (
    (
        "--data",
        "DIR",
        "relate, order, run, rearrange, towers, libero, assemblies, cans, mbm, speed, tamp, truth: a folder",
    ),
    ("--piles", "DIR", "order: score recorded piles of a folder; truth: those too, beside --data"),
    (
        "--against",
        "COMMIT",
        "truth, speed: compare with a commit of the checkout; run: JOURNAL, with its seeds",
    ),
    ("--scenario", "NAME", "run: the series of one scenario alone"),
    ("--meshes", "DIR", "paper: YCB models, as 011_banana; run: those that piles of others are made of"),
    ("--scenes", "DIR", "paper: write its scenes there, for other commands"),
    ("--journal", "FILE", "run, demo, engines: keep what ended there, and go on (topple-bench-run.jsonl)"),
    ("--counts", "FILE", "demo: write what `topple demo` tells of its seeds"),
    (
        "--part",
        "PART",
        "reliability: readers, sabotages, faults, kills or soak alone; motion: motions, grasps or plans",
    ),
    ("--page", "FILE", "put the table of one bench into a page, between its marks"),
)
_SWITCHES = (
    ("--quick", "smaller and fewer cases: below two minutes"),
    ("--write", "truth: raise the floors to today's figures"),
    ("--markdown", "print the table as the pages of the docs have it"),
)
_HEADINGS = ("what", "tried", "held", "value", "baseline", "its value", "ratio", "bar", "")
_NUMBERS = ("tried", "held", "value", "its value", "ratio")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    parser.add_argument(
        "name",
        nargs="?",
        metavar="NAME",
        help=f"{', '.join(BENCHES)} (all of these, one by one), or {', '.join(CHECKS)}",
    )
    for option, metavar, purpose in _WITH_VALUES:
        parser.add_argument(option, metavar=metavar, help=purpose)
    for option, purpose in _SWITCHES:
        parser.add_argument(option, action="store_true", help=purpose)
    minutes = "run, demo, engines, build: begin nothing after it; 0 counts what was kept"
    parser.add_argument("--minutes", **value("M", minutes, from_zero))
    add_jobs(parser)
    parser.add_argument("--seeds", **value("N", "engines: seeds of each scene (40)", count))
    add(parser, "--ahead", more=": run")
    add(parser, "--verify", more=": order, which is slow")
    add(parser, *COMMON)


def execute(args: argparse.Namespace) -> int:
    """Measure and print; 1 where a figure misses its bar."""
    if args.fixed or args.up:
        complain("--fixed and --up are ignored: a bench makes its own scenes")
    for variable in _THREADS:  # one thread on both sides: CPU times of idle ones would count as work
        os.environ.setdefault(variable, "1")
    names = BENCHES if args.name is None else (args.name,)
    if args.page:
        if args.name is None:
            raise InvalidInput("--page takes the table of one bench: name it before --page FILE")
        replaced_table(_page(args.page), _title(args.name, vars(args)), [])  # refused now, not after hours
    code = DONE
    for name in names:
        options = _options(args, name)
        with ExitStack() as stack:
            if "executor" in options_of(name):
                spread = executor_at(args.cluster, args.jobs or os.cpu_count() or 1)
                options["executor"] = stack.enter_context(spread)
            progress = stack.enter_context(Progress(f"bench {name}"))
            document = bench(name, quick=args.quick, seed=args.seed, progress=progress, **options)
        if args.page:
            write_whole(
                args.page,
                replaced_table(_page(args.page), _title(document["bench"], document), markdown(document)),
            )
        if args.json:
            print_json(document)
        elif args.markdown:
            print_text(*markdown(document))
        else:
            _print(document)
        if any(row["ok"] is False for row in document["rows"]):
            code = MISSED
    return code


def _title(name: str, given: Mapping[str, Any]) -> str:
    """What the marks of a table name: the bench, and its part where that alone was measured."""
    parts = [key for key in ALONE if key in options_of(name) and given.get(key) is not None]
    return " ".join([name, *(f"--{key} {given[key]}" for key in parts)])


def _options(args: argparse.Namespace, name: str) -> dict[str, Any]:
    """Of the options, those that were given and that a bench takes."""
    given = {key: getattr(args, key) for key in options_of(name) if key != "executor"}
    found = {key: value for key, value in given.items() if value is not None}
    for key in found.keys() & {"data", "piles", "meshes"}:
        found[key] = _folder(found[key])
    if "scenes" in found:
        found["scenes"] = make_folder(found["scenes"])
    for key in found.keys() & {"journal", "counts"}:
        found[key] = Path(found[key])
    return found


def _page(path: str) -> str:
    try:
        return check_writable(path).read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"{path} is no page that can be read: {error}") from error


def _folder(text: str) -> Path:
    if not Path(text).is_dir():
        raise InvalidInput(f"{text} is no folder: give one that exists")
    return Path(text)


def markdown(document: Mapping[str, Any]) -> list[str]:
    """A bench's table as Markdown, with what it was measured on.

    Args:
        document: A `topple.bench` document.

    Returns:
        The lines; columns that no row fills are left out.
    """
    machine, size = document["machine"], "--quick, " if document["quick"] else ""
    title = _title(document["bench"], document)
    said = f"`topple bench {title}`: {size}seed {document['seed']}, {machine['processor']}"
    lines: list[str] = []
    for headings, cells, right in _tables(document["rows"]):
        lines += [*markdown_table([heading or "bar held" for heading in headings], cells, right), ""]
    return [*lines, f"{said}, {machine['cores']} cores."]


Table = tuple[list[str], list[tuple[str, ...]], list[int]]
"""Headings, cells, and which columns are aligned right."""


def _tables(rows: Sequence[Mapping[str, Any]]) -> list[Table]:
    """One figure a line, then those that stand side by side; with a line as well where they have a bar."""
    lines = [row for row in rows if "column" not in row or row["bar"] is not None]
    beside = [row for row in rows if "column" in row]
    return [*([_listed(lines)] if lines else []), *([_side_by_side(beside)] if beside else [])]


def _listed(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A figure a line, without columns that no row fills."""
    columns = [list(column) for column in zip(*map(_cells, rows), strict=True)]
    used = [k for k, column in enumerate(columns) if any(column)]
    headings = [_HEADINGS[k] for k in used]
    right = [k for k, heading in enumerate(headings) if heading in _NUMBERS]
    return headings, list(zip(*(columns[k] for k in used), strict=True)), right


def _side_by_side(rows: Sequence[Mapping[str, Any]]) -> Table:
    """A column for each method, then one for each baseline; a line for each thing that was measured."""
    ours = dict.fromkeys(row["column"] for row in rows)
    theirs = dict.fromkeys(row["baseline"] for row in rows if row["baseline_value"] is not None)
    lines: dict[str, dict[str, str]] = {}
    for row in rows:
        line = lines.setdefault(f"{row['what']} [{row['unit']}]" if row["unit"] else row["what"], {})
        line[row["column"]] = _figure(row["value"], "")
        if row["baseline_value"] is not None:
            line[row["baseline"]] = _figure(row["baseline_value"], "")
    columns = [*ours, *theirs]
    cells: list[tuple[str, ...]] = [
        (what, *(line.get(column, "") for column in columns)) for what, line in lines.items()
    ]
    return ["what", *columns], cells, list(range(1, len(columns) + 1))


def _print(document: Mapping[str, Any]) -> None:
    rows: Sequence[Mapping[str, Any]] = document["rows"]
    machine, title = document["machine"], _title(document["bench"], document)
    size = "quick" if document["quick"] else "full"
    print_text(
        f"topple bench {title}, {size}, seed {document['seed']}: "
        f"{machine['processor']}, {machine['cores']} cores"
    )
    headings, cells, right = _listed(rows)  # a line each: many columns have no room in a terminal
    print_table(headings, cells, right=right)
    for row in rows:
        print_text(*(f"{row['what']}: {' '.join(said.split())}" for said in row.get("wrong", ())))
        for one in row.get("differences", ()):
            parts = f" ({', '.join(one['parts'])})" if one["parts"] else ""
            print_text(f"{one['what']}{parts}", f"  was  {one['was']}", f"  now  {one['now']}")
    held = [row for row in rows if row["bar"] is not None]
    missed = sum(row["ok"] is False for row in held)
    print_text(
        f"{len(held) - missed} of {len(held)} bars cleared" + (f", {missed} missed." if missed else ".")
    )


def _cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    value = _figure(row["value"], row["unit"])
    if "interval" in row:
        low, high = row["interval"]
        value += f" [{low:.3g}, {high:.3g}]"
    verdict = {None: "", True: "ok", False: "MISSED"}[row["ok"]]
    return (
        f"{row['what']}, {row['column']}" if "column" in row else row["what"],
        *("" if row.get(key) is None else f"{row[key]:,}" for key in ("tried", "held")),
        value,
        row["baseline"] or "",
        "" if row["baseline_value"] is None else _figure(row["baseline_value"], row["unit"]),
        "" if row["ratio"] is None else f"{row['ratio']:.3g}x",
        row["bar"] or "",
        verdict,
    )


def _figure(value: float, unit: str) -> str:
    text = f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    return f"{text} {unit}".rstrip()
