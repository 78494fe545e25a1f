"""A scene as a planning problem in PDDL: what is on, in and before what; the domain is always the same."""

from collections.abc import Mapping
from typing import Any

from topple.planner.export.pddl import symbols_of
from topple.topology.base.errors import InvalidInput

DOMAIN = """; Facts of a scene as topple sees them. (before ?x ?y): taking ?y while ?x is there would move ?x.
(define (domain topple-scene)
  (:requirements :strips :typing :negative-preconditions :universal-preconditions)
  (:types thing)
  (:predicates
    (on ?x ?y - thing) (in ?x ?y - thing) (before ?x ?y - thing)
    (clear ?x - thing) (movable ?x - thing) (held ?x - thing) (aside ?x - thing) (hand-empty))
  (:action take :parameters (?x - thing)
    :precondition (and (hand-empty) (movable ?x) (clear ?x))
    :effect (and (held ?x) (not (hand-empty)) (not (clear ?x)) (not (aside ?x))
      (forall (?y - thing) (and (not (on ?x ?y)) (not (in ?x ?y)) (not (before ?x ?y))))))
  (:action see-clear :parameters (?x - thing)
    :precondition (and (not (held ?x)) (forall (?y - thing) (not (before ?y ?x))))
    :effect (and (clear ?x)))
  (:action put-aside :parameters (?x - thing)
    :precondition (and (held ?x))
    :effect (and (aside ?x) (clear ?x) (hand-empty) (not (held ?x))))
  (:action put-on :parameters (?x - thing ?y - thing)
    :precondition (and (held ?x) (clear ?y))
    :effect (and (on ?x ?y) (before ?x ?y) (clear ?x) (hand-empty) (not (held ?x)) (not (clear ?y))))
  (:action put-in :parameters (?x - thing ?y - thing)
    :precondition (and (held ?x) (clear ?y))
    :effect (and (in ?x ?y) (before ?x ?y) (clear ?x) (hand-empty) (not (held ?x)) (not (clear ?y)))))
"""


def scene_pddl(order: Mapping[str, Any]) -> tuple[str, str]:
    """The facts of a scene, and its targets as the goal.

    Args:
        order: What `topple order --json` prints, `Order.to_json()`.

    Returns:
        Text of the domain, which asks for quantifiers, and of the problem.

    Raises:
        InvalidInput: It is no such document.
    """
    try:
        edges = [(edge["first"], edge["then"], edge["reason"]) for edge in order["dependencies"]]
        held = [(s["supported"], s["supporter"], s["kind"]) for s in order["supports"]]
        movable = [*order["order"], *(name for edge in edges for name in edge[:2])]
        targets = order["targets"] or order["order"]
        symbols = symbols_of([*movable, *(name for support in held for name in support[:2])])
        facts: list[tuple[str, ...]] = [("in" if kind == "contained" else "on", x, y) for x, y, kind in held]
        facts += [("in", x, y) for x, y, reason in edges if reason == "contained"]
        facts += [("before", x, y) for x, y, _ in edges]
        facts += [("movable", name) for name in movable]
        facts += [("clear", name) for name in movable if name not in {edge[1] for edge in edges}]
        told = [f"({kind} {' '.join(symbols[each] for each in names)})" for kind, *names in facts]
        goal = " ".join(f"(aside {symbols[name]})" for name in targets)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise InvalidInput(
            f"this is no order: expected what `topple order --json` prints ({error!r})"
        ) from error
    init = "\n    ".join(dict.fromkeys(told))
    return (
        DOMAIN,
        f"""(define (problem topple-scene-now)
  (:domain topple-scene)
  (:objects {" ".join(symbols.values())} - thing)
  (:init (hand-empty)
    {init})
  (:goal (and {goal})))
""",
    )
