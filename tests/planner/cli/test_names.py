"""One name, one thing: no option means two, none has two names, and what had another name is still taken."""

import inspect
import re
from contextlib import suppress
from pathlib import Path

import pytest
from on_table import table

import topple.planner
import topple.robots
import topple.topology
from topple.planner.cli.main import COMMANDS, _parser
from topple.planner.grasp.rank import RankedGrasp
from topple.robots import Camera
from topple.topology import InvalidInput, Scene, relate
from topple.topology.base.public_names import OLD_NAMES, RENAMED

COMMON = {"--json", "--seed", "--fixed", "--up", "--version", "--max-mb", "--allow-outside"}
TWO_THINGS = [("export", "--to")]  # a format there, an arrangement elsewhere: both are promised
PACKAGES = (topple.topology, topple.robots, topple.planner)
EXPORTED = [getattr(package, name) for package in PACKAGES for name in package.__all__]


def test_an_option_means_one_thing_and_has_one_name():
    meant, named = dict[str, set[tuple[object, ...]]](), dict[str, set[str]]()
    for command in COMMANDS:
        actions = [each for each in _parser(command)[1][command]._actions if each.option_strings]
        assert {flag for action in actions for flag in action.option_strings} > COMMON, command
        for action in actions:
            flag, words = action.option_strings[-1], re.split(r"[:;,] | \(", action.help or "")[0]
            if (command, flag) not in TWO_THINGS:
                meant.setdefault(flag, set()).add((words, action.type, action.nargs, action.metavar))
                named.setdefault(re.sub(r" \(.*", "", action.help or ""), set()).add(flag)
    assert len(meant) > 80
    assert {flag: said for flag, said in meant.items() if len(said) > 1} == {}
    assert {words: flags for words, flags in named.items() if len(flags) > 1} == {}


@pytest.mark.parametrize(
    ("argv", "old", "new"),
    [
        (("rank", "no.npz", "no.npy", "OPTION", "cup"), "--object", "--target"),
        (("relate", "no.npz", "OPTION", "/labels"), "--labels", "--masks"),
        (("robot", "panda", "OPTION", "no/arm.png"), "-o", "--report"),
        (("robot", "panda", "OPTION=no/arm.png"), "--output", "--report"),
        (("bench", "none", "OPTION", "."), "--models", "--meshes"),
    ],
)
def test_an_old_option_is_taken_for_the_new_one_and_that_is_said(argv, old, new, typed):
    first, *rest = typed(*(word.replace("OPTION", old) for word in argv), code=2).err.splitlines()
    assert first == f"topple: {RENAMED.format(old, new)}"
    assert rest == typed(*(word.replace("OPTION", new) for word in argv), code=2).err.splitlines()


def test_old_parameters_warn_at_the_call():
    found = set[str]()
    for function in (*EXPORTED, Camera.looking_at, Scene.from_images):
        known = inspect.signature(function).parameters if hasattr(function, "__wrapped__") else ()
        for old in [old for old, new in OLD_NAMES.items() if new in known and old not in known]:
            with pytest.warns(DeprecationWarning, match=RENAMED.format(old, OLD_NAMES[old])) as caught:
                with suppress(InvalidInput, TypeError):
                    function(**{old: object()})
            assert caught[0].filename == __file__
            found.add(old)
    assert found >= {old for old in OLD_NAMES if " " not in old and old != "dropped"}


def test_what_has_an_old_name_is_the_same():
    scene = Scene({"table": table(0.3)}, up=(0, 0, 1))
    with pytest.warns(DeprecationWarning, match="most_objects is now max_objects"):
        assert relate(scene, most_objects=1) == relate(scene, max_objects=1)  # ty: ignore[unknown-argument]
    ranked = RankedGrasp(0, None, (), "out of reach")  # type: ignore[arg-type]
    with pytest.warns(DeprecationWarning, match="dropped is now why"):
        assert ranked.dropped == ranked.why and not ranked.feasible


def test_the_page_of_commands_lists_every_old_name():
    page = (Path(__file__).parents[3] / "docs" / "commands.md").read_text(encoding="utf-8").split("```")[1]
    assert all(re.search(rf"\b{old.split()[-1]}\b.*\n", page) for old in OLD_NAMES)
    assert all(re.search(rf"\b{new}\b", page) for new in OLD_NAMES.values())
