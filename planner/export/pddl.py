"""A plan as a planning problem in PDDL: what may be taken when, for any STRIPS planner to solve again."""

import re

from topple.planner.planning.plan_format import Plan


def pddl(plan: Plan) -> str:
    """Domain and problem.

    Plain STRIPS with typing: an object can be taken when all that has to go before it has been put down, so
    each object has an action of its own that names them. Solutions are the safe orders.

    Args:
        plan: The plan.

    Returns:
        The domain, a line `;; problem`, and the problem; `domain_and_problem` gives the two apart.
    """
    domain, problem = domain_and_problem(plan)
    return f"{domain}\n;; problem\n{problem}"


def domain_and_problem(plan: Plan) -> tuple[str, str]:
    """The two files of a planning problem.

    Args:
        plan: The plan.

    Returns:
        Text of the domain and of the problem.
    """
    symbols = symbols_of([step.object for step in plan.steps])
    before: dict[str, list[str]] = {name: [] for name in symbols}
    for step in plan.steps:
        for index in step.after:
            first = plan.steps[index].object
            if first != step.object and first not in before[step.object]:
                before[step.object].append(first)
    actions = [_actions(symbols[name], [symbols[first] for first in before[name]]) for name in symbols]
    constants = " ".join(symbols.values())
    domain = "\n".join(
        [
            f"; {_comment(plan.goal)}",
            "(define (domain topple)",
            "  (:requirements :strips :typing)",
            "  (:types thing)",
            f"  (:constants {constants} - thing)" if constants else "",
            "  (:predicates (there ?x - thing) (held ?x - thing) (put-down ?x - thing) (hand-empty))",
            *actions,
            ")",
        ]
    )
    goals = [symbols[step.object] for step in plan.steps if step.action != "remove"]
    there = " ".join(f"(there {symbol})" for symbol in symbols.values())
    wanted = " ".join(f"(put-down {symbol})" for symbol in dict.fromkeys(goals))
    problem = "\n".join(
        [
            "(define (problem topple-plan)",
            "  (:domain topple)",
            f"  (:init (hand-empty) {there})",
            f"  (:goal (and {wanted}))",
            ")",
        ]
    )
    return domain + "\n", problem + "\n"


def _actions(symbol: str, before: list[str]) -> str:
    gone = "".join(f" (put-down {first})" for first in before)
    return (
        f"  (:action take-{symbol}\n"
        f"    :parameters ()\n"
        f"    :precondition (and (hand-empty) (there {symbol}){gone})\n"
        f"    :effect (and (held {symbol}) (not (there {symbol})) (not (hand-empty))))\n"
        f"  (:action put-{symbol}\n"
        f"    :parameters ()\n"
        f"    :precondition (and (held {symbol}))\n"
        f"    :effect (and (put-down {symbol}) (hand-empty) (not (held {symbol}))))"
    )


def symbols_of(names: list[str]) -> dict[str, str]:
    """PDDL symbols for object names: letters, digits and dashes, no two alike."""
    found: dict[str, str] = {}
    for name in dict.fromkeys(names):
        plain = "o-" + (re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") or "x")
        symbol, number = plain, 2
        while symbol in found.values():
            symbol, number = f"{plain}-{number}", number + 1
        found[name] = symbol
    return found


def _comment(text: str) -> str:
    return " ".join(text.split())
