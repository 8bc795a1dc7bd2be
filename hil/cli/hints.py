"""Command lines that messages name, as in `hil reset m1`: with the options without which they would not work
where they are pasted."""

import re
import shlex
from typing import Any

_HINT = re.compile(r"`hil ([a-z][^`]*)`")
_words: list[str] = []
_root: list[Any] = []
"""The command `hil`, once its line is read."""


def begin(root: Any) -> None:
    """Begin a command line of ``root``, which asks no bench yet."""
    _root[:], _words[:] = [root], []


def ask_with(words: list[str]) -> None:
    """Note the options that the bench needs which this command line asks: as ``Found.options`` says them."""
    _words[:] = words


def pasteable(text: str, words: list[str] | None = None) -> str:
    """Text whose command lines in backquotes have the options ``words``; None: those that were noted."""
    options = shlex.join(_words if words is None else words)
    if not options:
        return text
    return _HINT.sub(lambda hint: f"`hil {options} {hint[1]}`" if _may_ask(hint[1]) else hint[0], text)


def all_pasteable(answer: Any, words: list[str] | None = None) -> Any:
    """A bench's answer with all its texts as ``pasteable`` has them."""
    if isinstance(answer, str):
        return pasteable(answer, words)
    if isinstance(answer, list):
        return [all_pasteable(each, words) for each in answer]
    if isinstance(answer, dict):
        return {name: all_pasteable(each, words) for name, each in answer.items()}
    return answer


def _may_ask(line: str) -> bool:
    if not _root:
        return False
    command = _root[0]
    for word in line.split():
        if not (below := hasattr(command, "commands") and command.get_command(None, word)):
            break
        command = below
    return asks_a_bench(command)


def asks_a_bench(command: Any) -> bool:
    """True if a command's --bench is one that runs: it does not complete the name in a way of its own."""
    return any(each.name == "bench" and not each._custom_shell_complete for each in command.params)
