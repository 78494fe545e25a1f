"""`topple check`: whether a scene stands, and what holds what up."""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

from topple.planner.cli.arguments import COMMON, add, add_many
from topple.planner.cli.console import print_json, print_table, print_text
from topple.planner.cli.main import DONE, NO_SAFE_PLAN
from topple.planner.cli.many import Kept, for_each_scene, store
from topple.planner.cli.options import Reading, scene_paths
from topple.planner.cli.tables import models_in, print_assumptions
from topple.topology.base.files import check_writable, write_whole


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    add_many(parser)
    add(parser, *COMMON)
    add(parser, "--no-margins", "--play", "--mend")
    add(parser, "--report", more=": of one scene, with forces and margins as arrows, out.html or out.png")


def execute(args: argparse.Namespace) -> int:
    """Check every scene; 1 where something does not stand, 2 where a scene cannot be read."""
    alone = args.mend is not None or args.report is not None
    paths = scene_paths(args, many=not alone)  # which may be among the names of --fixed
    if args.mend is not None:
        return _mend(Reading.of(args), paths[0], args.mend, args.json)
    drawn = None if args.report is None else check_writable(args.report)
    work = partial(_document, Reading.of(args), not args.no_margins, args.play, drawn)
    return for_each_scene(args, work, partial(_show, args.json), _code)


def _document(reading: Reading, margins: bool, played: bool, drawn: Path | None, path: str) -> dict[str, Any]:
    from topple.planner.stability.check import check
    from topple.topology.situation.situation import Situation

    situation = Situation.of(reading.scene(path))
    found = check(situation, margins=margins)
    document = {**found.to_json(), **models_in(situation.scene)}
    if played:
        from topple.planner.simulate.play import play

        document["played"] = play(situation, found).to_json()
    if drawn is not None:
        from topple.planner.report.check_page import check_page, check_picture

        as_picture = drawn.suffix.lower() == ".png"
        draw = check_picture if as_picture else partial(check_page, title=Path(path).name)
        write_whole(drawn, draw(situation.scene, document))
    return reading.said(situation.scene, document)


def _mend(reading: Reading, path: str, output: str, as_json: bool) -> int:
    """Write how a scene is mended; 1 where something does not stand then either."""
    import json

    from topple.planner.stability.mend import mend

    place = check_writable(output)
    found = mend(reading.scene(path))
    document = found.to_json()
    write_whole(place, json.dumps(document, indent=1) + "\n")
    if as_json:
        print_json({"scene": path, **document})
    else:
        told = [f"{name} {mm:.2g} mm" for name, mm in document["millimetres"].items()]
        left = [f"{name} {verdict}" for name, verdict in document["left"].items()]
        print_text(f"{path}: {'; '.join(told) or 'nothing'} moved, as {output} says")
        print_text("everything stands then" if not left else f"not mended: {', '.join(left)}")
    return DONE if not found.left else NO_SAFE_PLAN


def _code(document: Any) -> int:
    return DONE if document["stands"] else NO_SAFE_PLAN


def _show(as_json: bool, kept: Kept | None, path: str, document: dict[str, Any]) -> int:
    if not store(as_json, kept, path, document):
        print_text(f"{path}: {document['verdict']}")
        from topple.planner.decide.words import CHECK_HEADINGS, check_cells

        cells, headings = [check_cells(each) for each in document["objects"]], [*CHECK_HEADINGS]
        if "played" in document:
            _show_played(document["played"], path)
            headings.append(f"moved on {document['played']['engine']}")
            cells = [(*row, _distance_words(document["played"], row[0])) for row in cells]
        print_table(headings, cells, right=(3, 4, 5))
        print_assumptions(document["assumptions"])
    return _code(document)


def _show_played(played: dict[str, Any], path: str) -> None:
    """The line that says whether simulation agrees."""
    other = played["disagreeing"]
    told = f"otherwise: {', '.join(other)}" if other else "the same of all that is not in each other"
    print_text(f"{path}: {played['seconds']:g} s on {played['engine']} say {told}")


def _distance_words(played: dict[str, Any], name: str) -> str:
    """How far an object got in simulation, marked where statics says otherwise."""
    moved = played["moved"][name]
    mark = " !" if name in played["disagreeing"] else ""
    return f"{moved['mm']:.3g} mm, {moved['degrees']:.2g}°{mark}"
