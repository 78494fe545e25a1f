"""Entry point of the `topple` command: finds the sub-command, turns errors into one line and an exit code.

Each sub-command is a module: `add_arguments(parser)` adds its options, and `execute(args)` does it and gives
the exit code, 0 unless it says otherwise. Bad input raises `InvalidInput`; no safe plan `NoSafePlan`.

Nothing heavy is imported here: `topple --help` has to answer at once.
"""

import argparse
import importlib
import io
import logging
import os
import re
import sys
import warnings
from collections.abc import Sequence
from importlib.util import find_spec
from types import ModuleType
from typing import Any, NoReturn

from topple.planner.cli.arguments import ShowVersion
from topple.planner.cli.console import complain
from topple.topology.base.public_names import RENAMED, new_name

DONE, NO_SAFE_PLAN, WRONG_USE, CRASHED, INTERRUPTED = 0, 1, 2, 70, 130
"""70 as in sysexits: what went wrong is neither the input nor the plan."""

COMMANDS = {
    "relate": "decide how every two objects lie to each other",
    "order": "say in which order to take objects, and why",
    "check": "say whether a scene stands, what holds what up, and by how much",
    "plan": "plan grasps, placements and motions of the whole sequence",
    "run": "rebuild a scene in simulation and do it with an arm, looking again after every action",
    "robot": "say what was understood of an arm, and try its reach, its kinematics and a grasp in simulation",
    "scene": "make one scene of several views whose camera poses are only roughly known",
    "rank": "rank the grasps of another pipeline by what may be taken first, and say what bars the others",
    "score": "hold orders against labels that somebody else wrote: which pairs are right, false, missed",
    "demo": "play a built-in scene: look, order, plan and clear it with an arm in simulation",
    "bench": "measure relations, orders and motions on this machine, each with a baseline beside it",
    "export": "hand a plan on: PDDL, behaviour tree, DOT, GraphML, MoveIt scene, ROS 2",
    "mcp": "serve these tools to a language model over stdin and stdout (Model Context Protocol)",
    "view": "serve a scene as a live page: any deviation, its order or plan played, reasons at a click",
    "show": "draw a scene with its relations and its order",
}

EXAMPLES = {
    "relate": ("relate frame.npz", "relate clouds/ --fixed table --json"),
    "order": ("order frame.npz plate", "order clouds/ --fixed table --up 0 0 1 --target plate --json"),
    "check": ("check scene.xml", "check frame.npz --report page.html"),
    "plan": (
        "plan frame.npz plate -o plan.json",
        "plan frame.npz --goal 'empty bowl' --robot iiwa --away bin",
    ),
    "run": ("run frame.npz plate --report run.html", "run frame.npz --robot ur5e --gripper robotiq_2f_85"),
    "robot": ("robot ur5e --gripper robotiq_2f_85", "robot arm.urdf --gripper hand.toml"),
    "scene": ("scene left.npz right.npz -o both.npz", "scene left.npz right.npz --same-labels --json"),
    "rank": ("rank frame.npz grasps.npy", "rank frame.npz grasps.npy --target mug --json"),
    "score": ("score pile.npz", "score piles/*.npz --json"),
    "demo": ("demo --list", "demo pile --cameras 1 --wrist-camera"),
    "bench": ("bench relate --quick", "bench check --markdown"),
    "export": ("export plan.json --to pddl", "export plan.json --to bt -o tree.xml"),
    "mcp": ("mcp --root scenes", "mcp --root scenes --fixed table --max-mb 50"),
    "view": ("view frame.npz", "view frame.npz --plan plan.json"),
    "show": ("show frame.npz -o page.html", "show frame.npz --target plate -o picture.png"),
}
"""Two calls of each command, as its help ends with them."""

_MEASURING = ("bench", "score")  # which stand in the layer above

_START = """topple says what a robot can safely take next from a cluttered scene, and why.

  topple demo                                 see it: an arm clears a plate in simulation
  topple order SCENE.npz --target NAME        what must go first to free NAME, and why
  topple show SCENE.npz -o page.html          the same as a page to turn and zoom

SCENE is a cloud or mesh per object, or an RGB-D frame with a mask. All commands: topple help
"""

_EPILOG = (
    "exit codes: 0 done; 1 no safe plan or a failed run; 2 wrong use or unreadable input;\n"
    "70 a fault of topple itself; 130 interrupted"
)


class _Help(argparse.RawDescriptionHelpFormatter):
    """Help that keeps the lines of its examples; what an option says last, in brackets, is its default."""

    def _get_help_string(self, action: argparse.Action) -> str | None:
        words = action.help
        return None if words is None else re.sub(r" \(([^()]+)\)$", r" [default: \1]", words)


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, and for which -1e-3 is a number and no option."""

    def __init__(self, *args: Any, **keywords: Any) -> None:
        super().__init__(*args, **keywords)
        self._negative_number_matcher = re.compile(r"-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$", re.IGNORECASE)

    def error(self, message: str) -> NoReturn:
        """Print what is wrong, what was meant and where to read on, and leave with exit code 2."""
        from topple.topology.base.errors import suggestion

        wrong = re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message)
        if wrong:
            meant = suggestion(wrong[1], re.findall(r"[\w-]+", wrong[2])).strip()
            message += f"; {meant}" if meant else ""
        self.exit(WRONG_USE, f"{self.prog}: {message} (see {self.prog} --help)\n")

    def refuse(self, unknown: Sequence[str]) -> NoReturn:
        """Leave because of arguments that it does not have."""
        from topple.topology.base.errors import suggestion

        options = [flag for action in self._actions for flag in action.option_strings]
        meant = suggestion(unknown[0].partition("=")[0], options) if unknown[0].startswith("--") else ""
        self.error("; ".join(filter(None, [f"unrecognized arguments: {' '.join(unknown)}", meant.strip()])))


class _ShowCompletion(argparse.Action):
    """Prints a shell's completion script; every command's options are read for it."""

    def __call__(self, parser: argparse.ArgumentParser, _: object, shell: object, *__: object) -> None:  # type: ignore
        """Print the script and leave."""
        from topple.planner.cli.completion import completion

        parsers = {name: _parser(name)[1][name] for name in COMMANDS if _is_here(name)}
        sys.stdout.write(completion(str(shell), parsers))
        parser.exit(DONE)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        argv: Arguments after the program's name; those of the process where None.

    Returns:
        The exit code: 0 done, 1 no safe plan or a failed run, 2 wrong use or unreadable input, 70 a fault of
        topple itself, 130 interrupted.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    # small matrices by the thousand: BLAS threads cost more than they bring, and processes share the cores
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if not sys.warnoptions:  # what topple has to say it says itself, in a line
        warnings.simplefilter("ignore")
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by the caller: nobody reads, or has anything to say
            setattr(sys, name, open(os.devnull, "r" if name == "stdin" else "w"))
    if isinstance(sys.stdout, io.TextIOWrapper):  # a name the terminal cannot show is no reason to stop
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        code = _run(arguments)
        sys.stdout.flush()
    except SystemExit as leaving:  # argparse: help, version, or an error it has printed
        return leaving.code if isinstance(leaving.code, int) else DONE
    except KeyboardInterrupt:
        complain("interrupted")
        return INTERRUPTED
    except BrokenPipeError:  # whoever read our output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return DONE
    except OSError as error:
        complain(f"{error.filename or 'output'}: {error.strerror or error}")
        return WRONG_USE
    except Exception as error:  # what nobody foresaw: a fault of topple, told apart from a refusal
        complain(_report_crash(error, arguments))
        return CRASHED
    return code


def _report_crash(error: Exception, arguments: list[str]) -> str:
    """One line for a fault of topple, its trace written down."""
    import tempfile
    import traceback

    what = " ".join(f"{type(error).__name__}: {error}".split())[:200]
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="topple-crash-", suffix=".txt", delete=False, encoding="utf-8"
        ) as file:
            file.write(f"topple {' '.join(arguments)}\n")
            file.write("".join(traceback.format_exception(error)))
        where = f"the trace is in {file.name}"
    except OSError:
        where = "its trace could not be written"
    return f"a fault of topple itself, please report it ({what}); {where}"


def _run(arguments: list[str]) -> int:
    if arguments[:1] == ["help"]:
        arguments = [*arguments[1:2], "--help"]
    chosen = next((argument for argument in arguments if not argument.startswith("-")), None)
    parser, commands = _parser(chosen)
    if not arguments:
        sys.stdout.write(_START)
        return DONE
    if chosen in commands:
        _take_old_names(str(chosen), commands[chosen], arguments)
    args, unknown = parser.parse_known_args(arguments)
    if unknown:
        commands.get(args.command, parser).refuse(unknown)
    if args.command is None:
        parser.error(f"no command given; choose from {', '.join(COMMANDS)}")
    command = _module(args.command)
    from topple.topology.base.errors import InvalidInput, ToppleError

    args.parser, args.said = commands[args.command], tuple
    logging.basicConfig(format="topple: %(message)s")  # warnings: of plugins that are left out
    try:
        return int(command.execute(args))
    except InvalidInput as error:
        complain(str(error))
        return WRONG_USE
    except ToppleError as error:  # no safe plan, or no place for the arm: the input was fine
        if args.command in ("plan", "run") and args.json:
            from topple.planner.cli.console import print_json
            from topple.planner.errors import refusal_json

            goal = args.goal or args.to or f"free {' '.join(args.target)}"
            print_json(refusal_json(args.command, error, goal))
        message, *certificate = args.said((str(error), *getattr(error, "certificate", ())))
        complain(message, *(line for line in certificate if line not in message))
        return NO_SAFE_PLAN


def _parser(chosen: str | None) -> tuple[_Parser, dict[str, _Parser]]:
    """Build the parser; only the chosen command's module is imported for its options."""
    parser = _Parser(
        prog="topple",
        description="Which object in the clutter to take next, and why that is safe.",
        epilog=_EPILOG,
    )
    parser.add_argument("--version", action=ShowVersion, nargs=0, help="print version and kernels, and leave")
    told = "print a shell's completion script and leave"
    parser.add_argument("--completion", action=_ShowCompletion, choices=("bash", "zsh"), help=told)
    actions = parser.add_subparsers(dest="command", metavar="COMMAND", parser_class=_Parser)
    commands: dict[str, _Parser] = {}
    for name, purpose in COMMANDS.items():
        calls = [f"  topple {call}" for call in EXAMPLES.get(name, ())]
        commands[name] = actions.add_parser(
            name,
            help=purpose,
            description=purpose[0].upper() + purpose[1:] + ".",
            epilog="\n".join(["examples:", *calls, "", _EPILOG]),
            formatter_class=_Help,
        )
        if name == chosen and not _is_here(name):
            parser.error(f"{name} works in a checkout of topple alone, which has what it measures")
        if name == chosen:
            _module(name).add_arguments(commands[name])
    return parser, commands


def _take_old_names(command: str, parser: _Parser, arguments: Sequence[str]) -> None:
    """Have old names of options, where they are used, mean the new ones, and say so."""
    actions = parser._option_string_actions
    known = [flag.lstrip("-") for flag in actions]
    for flag in [argument.partition("=")[0] for argument in arguments]:
        new = f"--{new_name(flag.lstrip('-'), known, command)}"
        if flag.startswith("-") and flag not in actions and new in actions:
            complain(RENAMED.format(flag, new))
            actions[flag] = actions[new]


def _path(command: str) -> str:
    return f"topple.{'benchmarks.commands' if command in _MEASURING else 'planner.cli'}.{command}"


def _is_here(command: str) -> bool:
    """Whether a command is installed: the wheel leaves the benches out."""
    return command not in _MEASURING or find_spec(_path(command)) is not None


def _module(command: str) -> ModuleType:
    return importlib.import_module(_path(command))


if __name__ == "__main__":
    sys.exit(main())
