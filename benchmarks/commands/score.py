"""`topple score`: how well an order agrees with labels that somebody else wrote."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from topple.benchmarks.guesses import Guess
from topple.benchmarks.labels import read_truth
from topple.benchmarks.scores import Score, f1_interval, judged, score, share_interval, unsafe_steps
from topple.planner.cli.arguments import COMMON, add, add_jobs, add_scenes
from topple.planner.cli.console import print_json, print_table, print_text
from topple.planner.cli.main import DONE
from topple.planner.cli.many import for_each_scene
from topple.planner.cli.options import Reading, orderer_of, rule_of, scene_paths
from topple.topology.base.errors import InvalidInput

if TYPE_CHECKING:
    from topple.planner.planning.step import Orderer
    from topple.topology.relations.relate import Relations
    from topple.topology.scene.scene import Scene

FORMAT, FORMAT_VERSION = "topple.score", 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    add_scenes(
        parser,
        "SCENE...",
        "scenes, or orders as `topple order --json` prints them (.json), of topple or another program",
    )
    parser.add_argument(
        "--labels",
        dest="truth",
        nargs="+",
        metavar="FILE",
        help="one per scene: labels of a pile, mrt.json of REGRAD, .xml of VMRD, order.csv of MetaGraspNet "
        "(what recorded piles hold)",
    )
    add_jobs(parser)
    add(parser, "--verify", "--rule", "--orderer", *COMMON)


def execute(args: argparse.Namespace) -> int:
    """Order every scene, hold the orders against labels, print the counts; 2 where one cannot be read."""
    paths = scene_paths(args)
    given: list[str] = args.truth or paths
    if len(given) != len(paths):
        args.parser.error(f"{len(paths)} scenes and {len(given)} files of labels: expected one per scene")
    if len(set(paths)) < len(paths):
        args.parser.error("a scene is given twice: expected each once")
    if args.orderer is not None and args.verify:
        args.parser.error("--verify is about topple's own order: leave out --orderer")
    total: list[Score] = []
    how = _How(Reading.of(args), rule_of(args), orderer_of(args), args.seed, args.verify)
    work = partial(_scored, how, dict(zip(paths, given, strict=True)))
    show = partial(_show, args.json, total)
    code = for_each_scene(args, work, lambda _, path, found: show(path, found), processes=not args.verify)
    if len(paths) > 1 and total:
        _show_all(args.json, total)
    return code or DONE


@dataclass(frozen=True)
class _How:
    """How scenes are read and ordered; it can go to another process."""

    reading: Reading
    relating: "Callable[[Scene], Relations] | None"
    orderer: "Orderer | None"
    seed: int
    verify: bool


def _scored(how: _How, labels: Mapping[str, str], path: str) -> dict[str, Any]:
    """The counts of one scene."""
    truth = read_truth(Path(labels[path]))
    guess, objects = _order_read(path) if path.endswith(".json") else _order_found(how, path)
    named = truth.named(objects)
    counts, pairs = score(guess, named, objects), judged(guess, named, objects)
    moved = unsafe_steps(guess, named, [name for name in named if name in objects])
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "scene": path,
        "labels": labels[path],
        "labels_format": truth.format,
        **_figures(counts),
        "missed_pairs": [{"first": first, "then": then} for first, then in pairs.missed],
        "false_pairs": [{"first": first, "then": then} for first, then in pairs.false],
        "unsafe": [{"object": name, "moves": list(others)} for name, others in moved],
        "unseen": sorted(name for name in named if name not in objects),
    }


def _order_found(how: _How, path: str) -> "tuple[Guess, tuple[str, ...]]":
    """The order of a scene file, and what may be taken there."""
    from topple.planner.planning.order import order

    scene = how.reading.scene(path)
    relations = None if how.relating is None else how.relating(scene)
    if how.orderer is not None:
        from topple.planner.planning.step import order_by

        found = order_by(how.orderer, scene, None, relations, how.seed)
    else:
        found = order(scene, seed=how.seed, verify=how.verify, relations=relations)
    return _guess(found.to_json()), scene.movable


def _order_read(path: str) -> "tuple[Guess, tuple[str, ...]]":
    """An order that was written, and the objects that it is about."""
    from topple.topology.io.strict_json import read_json

    try:
        document: Any = read_json(Path(path).read_text(encoding="utf-8"), "the file")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"{path}: cannot be read: {error}") from error
    try:
        told = document["format"], document.get("format_version", 1)
        if told != ("topple.order", 1):
            raise InvalidInput(f"{path} is a {told[0]} of version {told[1]}: expected a topple.order of 1")
        guess = _guess(document)
    except (KeyError, TypeError, ValueError) as error:
        raise InvalidInput(
            f"{path}: expected a topple.order with order and dependencies, lacks {error}"
        ) from error
    named = {name for pair in guess.pairs for name in pair}.union(guess.order)
    return guess, tuple(sorted(named))


def _guess(document: Mapping[str, Any]) -> "Guess":
    return Guess(
        pairs=frozenset((str(edge["first"]), str(edge["then"])) for edge in document["dependencies"]),
        order=tuple(str(name) for name in document["order"]),
        groups=tuple(tuple(str(name) for name in group) for group in document.get("groups", ())),
    )


def _figures(counts: "Score") -> dict[str, Any]:
    return {
        "f1": counts.f1, "precision": counts.precision, "recall": counts.recall, "right": counts.right,
        "false": counts.false, "missed": counts.missed, "safe": counts.safe, "scenes": counts.piles,
        "unsafe_steps": counts.unsafe, "steps": counts.steps,
    }  # fmt: skip


def _show(as_json: bool, total: "list[Score]", path: str, document: dict[str, Any]) -> int:
    keys = {"unsafe_steps": "unsafe", "scenes": "piles"}
    names = ("right", "false", "missed", "safe", "scenes", "unsafe_steps", "steps")
    total.append(Score(**{keys.get(name, name): document[name] for name in names}))
    if as_json:
        print_json(document)
        return DONE
    print_text(
        f"{path}, labels of {document['labels_format']}: F1 {document['f1']:.3f}, "
        f"{document['right']} pairs right, {document['false']} false, {document['missed']} missed; "
        f"the order is {'safe' if document['safe'] else 'not safe'}"
    )
    rows = [("missed", pair["first"], pair["then"]) for pair in document["missed_pairs"]]
    rows += [("false", pair["first"], pair["then"]) for pair in document["false_pairs"]]
    if rows:
        print_table(("", "first", "then"), rows)
    for step in document["unsafe"]:
        print_text(f"{step['object']} is taken while {', '.join(step['moves'])} would move.")
    if document["unseen"]:
        print_text(f"Labelled and not in the scene: {', '.join(document['unseen'])}.")
    return DONE


def _show_all(as_json: bool, scores: "list[Score]") -> None:
    """The counts of all scenes together."""
    total = sum(scores, Score())
    low, high = f1_interval(scores)
    shares = share_interval(total.safe, total.piles)
    if as_json:
        head = {"format": FORMAT, "format_version": FORMAT_VERSION, "scene": None, **_figures(total)}
        print_json({**head, "f1_interval": [low, high], "safe_interval": [share / 100 for share in shares]})
        return
    print_text(
        f"all {total.piles} scenes: F1 {total.f1:.3f} ({low:.3f} to {high:.3f}), precision "
        f"{total.precision:.3f}, recall {total.recall:.3f} ({total.right} right, {total.false} false, "
        f"{total.missed} missed); safe orders {total.safe} of {total.piles} ({shares[0]:.0f} to "
        f"{shares[1]:.0f} %), unsafe steps {total.unsafe} of {total.steps}"
    )
