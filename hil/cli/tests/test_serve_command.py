"""``hil serve`` has a command line of its own, which says what that of all commands says."""

import subprocess
import sys

from typer.testing import CliRunner

from hil.cli import cli, serve_command


def test_it_starts_without_what_other_commands_import() -> None:
    program = (
        "import sys; sys.argv = ['hil', 'serve', '--help']\n"
        "from hil.cli.entry import main\n"
        "try: main()\n"
        "except SystemExit: print([name for name in sys.modules if name.endswith(('cli.cli', '_commands'))])"
    )
    said = subprocess.check_output([sys.executable, "-c", program], text=True)
    assert said.startswith("Usage: hil serve [OPTIONS]")
    assert said.endswith("\n[]\n")


def test_help_and_mistakes_are_those_of_the_whole_command_line() -> None:
    for arguments in (["serve", "--help"], ["serve"], ["serve", "--bad"], ["serve", "a.yaml", "b.yaml"]):
        whole, own = (CliRunner().invoke(app, arguments) for app in (cli.app, serve_command.app))
        assert (whole.output, whole.exit_code) == (own.output, own.exit_code)
        assert whole.output
