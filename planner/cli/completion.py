"""Shell completion: `topple --completion bash|zsh`, a script made from the commands' own options."""

import argparse
from collections.abc import Mapping

SHELLS = ("bash", "zsh")


def completion(shell: str, parsers: Mapping[str, argparse.ArgumentParser]) -> str:
    """Write the completion script of a shell; that of zsh is bash's, which it understands.

    Args:
        shell: One of `SHELLS`.
        parsers: Every command with its options.

    Returns:
        The script, to be sourced: `source <(topple --completion bash)`.
    """
    from topple.planner.execution.demo_seeds import counted_scenes
    from topple.planner.export import EXPORTERS
    from topple.robots.catalog import names

    values = {"--robot": names(), "--to": list(EXPORTERS), "--cameras": "123", "--completion": SHELLS}
    after = "\n".join(f'    {flag}) words="{" ".join(known)}" ;;' for flag, known in values.items())
    each = "\n".join(
        f'    {name}) options="{" ".join(_options(parser))}" ;;' for name, parser in parsers.items()
    )
    return f"""{"autoload -U +X bashcompinit && bashcompinit" if shell == "zsh" else ""}
_topple() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} options= words=
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W "{" ".join(parsers)} --help --version --completion" -- "$word")); return
  fi
  case ${{COMP_WORDS[1]}} in
{each}
  esac
  if [ "${{COMP_WORDS[1]}}" = demo ]; then words="{" ".join(counted_scenes())}"; fi
  case $before in
{after}
  esac
  if [[ $word == -* ]]; then words=$options; fi
  if [ -n "$words" ]; then COMPREPLY=($(compgen -W "$words" -- "$word")); else COMPREPLY=(); fi
}}
complete -o default -F _topple topple
"""


def _options(parser: argparse.ArgumentParser) -> list[str]:
    """The long options of a command."""
    flags = [flag for action in parser._actions for flag in action.option_strings]
    return [flag for flag in flags if flag.startswith("--")]
