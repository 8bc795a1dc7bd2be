"""``hil serve`` starts without what the other commands import."""

import subprocess
import sys


def test_it_starts_without_what_other_commands_import() -> None:
    program = (
        "import sys; sys.argv = ['hil', 'serve', '--help']\n"
        "from hil.cli.entry import main\n"
        "try: main()\n"
        "except SystemExit: print([name for name in sys.modules if name.endswith('_commands')])"
    )
    said = subprocess.check_output([sys.executable, "-c", program], text=True)
    assert said.startswith("Usage: hil serve [OPTION...] FILE")
    assert said.endswith("\n[]\n")
