"""The command ``hil``."""

from hil.cli.command_group import command_line

app = command_line()
