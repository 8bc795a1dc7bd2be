"""Boards of the project, as they say themselves."""

import subprocess
import sys

from hil.compose import find_catalogue
from hil.vocab.profile import Profile


def test_each_profile_has_a_board_with_the_same_uarts() -> None:
    catalogue = find_catalogue()
    assert (
        list(catalogue.boards)
        == list(catalogue.profiles)
        == [
            *("as5047d", "canopen_drive", "easydriver", "mechaduino", "modbus_drive", "modbus_meter"),
            *("sac", "uno", "walter"),
        ]
    )
    for name, info in catalogue.profiles.items():
        assert isinstance(catalogue.boards[name], Profile)
        assert list(info.uarts) == list(catalogue.boards[name].uarts)


def test_finding_imports_no_board_and_a_command_no_other_board() -> None:
    look = "print([name for name in sys.modules if name.startswith('device_profiles.')])"
    found = f"import sys; from hil.compose import find_catalogue; find_catalogue(); {look}"
    assert subprocess.check_output([sys.executable, "-c", found], text=True) == "[]\n"
    command = f"import sys; import hil.cli.framework.command_group; {look}"
    assert subprocess.check_output([sys.executable, "-c", command], text=True) == "[]\n"
