"""Public data sheets of real drives, if ``HIL_PUBLIC_EDS`` names a folder with such files: ``*.eds`` and
``*.dcf``. None is part of this project: their licences differ.

Each becomes a node, and the ``canopen`` library with the same file reads every object, is refused what the
file forbids, and moves the drive in the modes that it has.
"""

import os
from pathlib import Path

import pytest
from maker_rig import MakerWorld, differences, enable, move_to, refusals, said_by_dcfchk

from hil.wire.outside_text import text_of

FOLDER = os.environ.get("HIL_PUBLIC_EDS", "")
FILES = sorted(Path(FOLDER).glob("*.[ed][dc][sf]")) if FOLDER else []


@pytest.mark.skipif(not FILES, reason="HIL_PUBLIC_EDS names no folder with data sheets")
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_a_master_takes_the_drive_of_a_public_file(file: Path, tmp_path: Path) -> None:
    world = MakerWorld(text_of(file.read_bytes()))
    master = world.master()
    assert differences(world, master) == []
    assert refusals(world, master) == []
    assert said_by_dcfchk(world.exported(), tmp_path) == ""
    modes = world.node._application._modes if 0x6060 in master.object_dictionary else ()
    if 1 in modes:
        enable(world, master, 1)
        assert abs(move_to(world, master, 2500) - 2500) <= 1
    elif 7 in modes:
        enable(world, master, 7)
