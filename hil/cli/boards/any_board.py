"""Verbs that any board has, which have a command of their own: `hil reset m1` is `hil axis m1 reset`."""

import sys
from collections.abc import Collection

OF_ANY_BOARD = {"reset": "", "pin": " NAME LEVEL", "zero": "", "type": " TEXT"}
"""Verbs with the words that each takes behind the device, as its command shows them."""


def of_any_board(device: str, verbs: Collection[str]) -> str:
    """Line that names those commands, for the list of a device's verbs."""
    own = [f"`hil {name} {device}{taken}`" for name, taken in OF_ANY_BOARD.items() if name in verbs]
    return f"As any board: {', '.join([*own, f'`hil stop {device}`'])}"


def say_own_command(device: str, name: str) -> None:
    """Say on standard error that a verb has a command of its own."""
    from hil.cli.framework.command_answers import pasteable
    from hil.host.journal import say

    say(pasteable(f"hil: any board has this: `hil {name} {device}{OF_ANY_BOARD[name]}`"), sys.stderr)
