"""Shell completion: `topple --completion bash|zsh|fish`, a script made from the commands' own options."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

SHELLS = ("bash", "zsh", "fish")


@dataclass(frozen=True)
class Command:
    """What can follow a command.

    Attributes:
        purpose: What it does, one line.
        options: Long option -> its help, one line.
        words: Words that it takes itself; none where it takes files.
    """

    purpose: str
    options: Mapping[str, str]
    words: Sequence[str]


def completion(
    shell: str, parsers: Mapping[str, argparse.ArgumentParser], purposes: Mapping[str, str]
) -> str:
    """Write the completion script of a shell.

    Args:
        shell: One of `SHELLS`.
        parsers: Every command with its options.
        purposes: What each command does.

    Returns:
        The script, to be sourced: `source <(topple --completion bash)`.
    """
    from topple.planner.execution.demo_seeds import counted_scenes
    from topple.planner.export import EXPORTERS
    from topple.robots.catalog import names

    words = {"demo": counted_scenes()}
    values: dict[str, Sequence[str]] = {
        "--robot": names(),
        "--to": tuple(EXPORTERS),
        "--cameras": ("1", "2", "3"),
    }
    commands = {
        name: Command(purposes[name], _options(parser), words.get(name, ()))
        for name, parser in parsers.items()
    }
    return {"bash": _bash, "zsh": _zsh, "fish": _fish}[shell](commands, values)


def _options(parser: argparse.ArgumentParser) -> dict[str, str]:
    """The long options of a command, with the first clause of their help."""
    told = [(flag, action.help or "") for action in parser._actions for flag in action.option_strings]  # pyright: ignore[reportPrivateUsage]
    return {flag: " ".join(help_.split(":")[0].split()) for flag, help_ in told if flag.startswith("--")}


def _bash(commands: Mapping[str, Command], values: Mapping[str, Sequence[str]]) -> str:
    after = "\n".join(f'    {flag}) words="{" ".join(known)}" ;;' for flag, known in values.items())
    each = "\n".join(
        f'    {name}) options="{" ".join(command.options)}"; words="{" ".join(command.words)}" ;;'
        for name, command in commands.items()
    )
    return f"""_topple() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} options= words=
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W "{" ".join(commands)} --help --version --completion" -- "$word")); return
  fi
  case ${{COMP_WORDS[1]}} in
{each}
    --completion) words="{" ".join(SHELLS)}" ;;
  esac
  case $before in
{after}
  esac
  if [[ $word == -* ]]; then words=$options; fi
  if [ -n "$words" ]; then COMPREPLY=($(compgen -W "$words" -- "$word")); else COMPREPLY=(); fi
}}
complete -o default -F _topple topple
"""


def _zsh(commands: Mapping[str, Command], values: Mapping[str, Sequence[str]]) -> str:
    known = "\n".join(f"    {_quoted(f'{name}:{command.purpose}')}" for name, command in commands.items())
    after = "\n".join(
        f"    {flag}) compadd -- {' '.join(words)}; return ;;" for flag, words in values.items()
    )
    each = "\n".join(
        f"    {name}) options=({' '.join(command.options)}); words_=({' '.join(command.words)}) ;;"
        for name, command in commands.items()
    )
    return f"""#compdef topple
_topple() {{
  local -a commands options words_
  commands=(
{known}
  )
  if (( CURRENT == 2 )); then
    _describe command commands; compadd -- --help --version --completion; return
  fi
  case $words[CURRENT-1] in
{after}
    --completion) compadd -- {" ".join(SHELLS)}; return ;;
  esac
  case $words[2] in
{each}
  esac
  if [[ $words[CURRENT] == -* ]]; then compadd -- $options
  elif (( $#words_ )); then compadd -- $words_
  else _files
  fi
}}
compdef _topple topple
"""


def _fish(commands: Mapping[str, Command], values: Mapping[str, Sequence[str]]) -> str:
    lines = [f"complete -c topple -n __fish_use_subcommand -l completion -xa '{' '.join(SHELLS)}'"]
    lines += ["complete -c topple -n __fish_use_subcommand -l version -l help"]
    for name, command in commands.items():
        lines.append(
            f"complete -c topple -f -n __fish_use_subcommand -a {name} -d {_quoted(command.purpose)}"
        )
        seen = f"complete -c topple -n '__fish_seen_subcommand_from {name}'"
        if command.words:
            lines.append(f"{seen} -f -a '{' '.join(command.words)}'")
        for flag, told in command.options.items():
            value = f" -xa '{' '.join(values[flag])}'" if flag in values else ""
            lines.append(f"{seen} -l {flag[2:]}{value} -d {_quoted(told)}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    """Text as one word of a shell."""
    return "'" + text.replace("'", "") + "'"
