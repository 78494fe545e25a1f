"""`topple order`: which object to take next, and why."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

from topple.planner.cli.arguments import COMMON, SEEN_ROBOT, add, add_many
from topple.planner.cli.console import complain
from topple.planner.cli.main import DONE, NO_SAFE_PLAN
from topple.planner.cli.many import Kept, for_each_scene, store
from topple.planner.cli.options import Reading, orderer_of, read_goal, rule_of, scene_paths
from topple.planner.cli.robot_options import arm_of
from topple.planner.cli.tables import (
    models_in,
    print_assumptions,
    print_build,
    print_moves,
    print_order,
)

if TYPE_CHECKING:
    from topple.planner.planning.step import Orderer
    from topple.topology.relations.relate import Relations
    from topple.topology.scene.scene import Scene
    from topple.topology.situation.situation import Situation


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options; see `topple.planner.cli.main`."""
    add_many(parser)
    add(parser, "--target", "--max-objects", "--rule", "--orderer", "--masks-as-they-are", *COMMON)
    add(parser, "--verify", more=": in simulation every object is taken away")
    add(parser, "--robot", more=": what bars the way of its gripper is said")
    add(parser, "--budget", more=", with --verify")
    add(parser, *SEEN_ROBOT, "--hands", "--clamped", "--next-view", "--explain")
    add(parser, "--build", "--to", "--match")


def execute(args: argparse.Namespace) -> int:
    """Order the objects of every scene; 1 where a cycle allows no safe order, 2 where one cannot be read."""
    if args.verify:
        import_module("topple.robots.engine")  # refused now, not after the work
    if args.budget is not None and not args.verify:
        args.parser.error("--budget bounds --verify: give both or neither")
    if args.gripper is not None and not args.robot:
        args.parser.error("--gripper is what the robot holds with: give both or neither")
    args.to = args.to if args.to is None else args.to or " "  # which is refused where it is read
    whole = "--build" if args.build else "--to"
    of_some = args.target or args.verify or args.robot or args.hands or args.clamped
    if (args.build or args.to) and (of_some or (args.build and args.to)):
        others = "--robot, --hands" + (", --clamped and --to" if args.build else " and --clamped")
        args.parser.error(f"{whole} is about the whole arrangement: leave --target, --verify, {others} out")
    own = args.verify or args.robot or args.hands or args.clamped or args.next_view or args.build or args.to
    if args.orderer is not None and own:
        others = "--verify, --robot, --hands, --clamped, --next-view, --build and --to"
        args.parser.error(f"{others} are about topple's own order: leave out --orderer")
    orderer, relating = orderer_of(args), rule_of(args)
    if args.max_objects is not None:
        from topple.topology.relations.relate import relate

        relating = partial(relating or relate, max_objects=args.max_objects)
    options = {key: getattr(args, key) for key in ("seed", "verify", "budget", "hands", "clamped")}
    options["robot"] = arm_of(args) if args.robot else None
    scene_paths(args)  # which may be among the names of --fixed and --target
    reading = Reading.of(args)
    ask: _Ask = partial(_remove, args.target, args.next_view, options)
    if args.build:
        ask = _built
    elif args.to:
        ask = partial(_moves, reading, args.to, args.match)
    elif orderer is not None:
        ask = partial(_ordered_by, orderer, args.target, args.seed)
    work = partial(_answer, reading, relating, ask)
    by_scenes = not (args.verify or args.robot)  # those take all cores, and import what prints when imported
    code = partial(_code, args.hands is not None or bool(args.clamped))
    return for_each_scene(args, work, partial(_show, args, code), code, by_scenes)


@dataclass(frozen=True)
class _Answer:
    """What is shown of an order."""

    document: dict[str, Any]
    movable: int
    certificate: tuple[str, ...]


_Asked = tuple[dict[str, Any], tuple[str, ...]]
"""A document, and why there is no safe order."""
_Ask = Callable[["Situation"], _Asked]
_Code = Callable[[Mapping[str, Any]], int]


def _answer(
    reading: Reading, relating: "Callable[[Scene], Relations] | None", ask: _Ask, path: str
) -> _Answer:
    """Load a scene file and answer the question about it."""
    from topple.topology.situation.situation import Situation

    scene = reading.scene(path)
    document, certificate = ask(Situation.of(scene, None if relating is None else relating(scene)))
    answer = _Answer({**document, **models_in(scene)}, len(scene.movable), certificate)
    return reading.said(scene, answer)


def _remove(target: list[str] | None, look: bool, options: dict[str, Any], situation: "Situation") -> _Asked:
    """The order in which things are taken, and from where to look next."""
    from topple.planner.planning.next_view import with_next_view
    from topple.planner.planning.order import order

    found = order(situation, target, **options)
    return with_next_view(situation, target, found) if look else found.to_json(), found.certificate


def _ordered_by(orderer: "Orderer", target: list[str] | None, seed: int, situation: "Situation") -> _Asked:
    """The order of another orderer."""
    from topple.planner.planning.step import order_by

    found = order_by(orderer, situation.scene, target, situation.known_relations, seed)
    return found.to_json(), found.certificate


def _built(situation: "Situation") -> _Asked:
    """The order in which things are put down."""
    from topple.planner.building.build import build_order

    return build_order(situation).to_json(), ()


def _moves(reading: Reading, goal: str, match: str, situation: "Situation") -> _Asked:
    """The order in which things are moved until they lie as in another scene."""
    from topple.planner.rearranging.rearrange import rearrange

    return rearrange(situation, read_goal(reading, goal), match=match).to_json(), ()


def _more_hands(document: Mapping[str, Any]) -> list[str]:
    """Say why an order takes more than one hand."""
    held = [hold for hold in document["holds"] if not hold.get("fixture")]
    groups = [f"{' and '.join(group)} hold each other" for group in document["groups"]]
    return groups or [f"{hold['object']} has to be held until {hold['until']} is there" for hold in held]


def _code(counted: bool, document: Mapping[str, Any]) -> int:
    """Whether one hand, or as many as were counted, can do it."""
    lacking = document.get("unresolved") or (not counted and _more_hands(document))
    return NO_SAFE_PLAN if lacking else DONE


def _print(path: str, answer: _Answer, explain: bool) -> None:
    if answer.document.get("build"):
        print_build(path, answer.document)
    elif "moves" in answer.document:
        print_moves(path, answer.document)
    else:
        print_order(path, answer.document, answer.movable, explain=explain)
    print_assumptions(answer.document["assumptions"])


def _show(args: argparse.Namespace, code: _Code, kept: Kept | None, path: str, answer: _Answer) -> int:
    if not store(args.json, kept, path, answer.document):
        _print(path, answer, args.explain)
    for words in answer.certificate:
        complain(f"{path}: no safe order: each has to go first, {words}")
    if code(answer.document) != DONE and not answer.certificate:
        whole = "" if answer.document.get("build") or "moves" in answer.document else " (--hands N)"
        complain(*(f"{path}: one hand cannot do it{whole}: {why}" for why in _more_hands(answer.document)))
    return code(answer.document)
