"""Preparations of the page about sketches: its files, and a compiler."""

import os
import re
import shutil
from pathlib import Path

import pytest
from markdown_blocks import blocks
from page_sessions import Session
from page_tables import before, carries_out

from hil.toolchain.avr_tools import core_of, find_avr_tools
from hil.toolchain.build_failed import NoToolchain

_FILE = re.compile(r"\w+\.(ino|yaml|py)")


def need_toolchain(*programs: str) -> None:
    """Skip the test where sketches cannot be built."""
    try:
        core_of(find_avr_tools({}))
    except NoToolchain as error:
        pytest.skip(str(error))
    for program in programs:
        if not shutil.which(program):
            pytest.skip(f"{program} is not installed")


def write_sketch(page: str, folder: Path) -> None:
    """Write the files of a page, which stand below their names, into a new folder."""
    folder.mkdir()
    for each in blocks(page):
        if _FILE.fullmatch(each.heading):
            (folder / each.heading).write_text(each.text)


@before("own-sketch", "Build it and run it")
def _(session: Session) -> None:
    need_toolchain("avrdude")
    session.folder = session.place.folder = session.folder / "turns"
    write_sketch(session.page, session.folder)
    os.chdir(session.folder)
    session.varies = (r"\d,\d{3} of", r"\(\d+ %\)", r"\d+ passed", r"in \d+\.\d+s")


@carries_out("own-sketch", "pytest")
def _(session: Session, command: str) -> str:
    """Carry the page's test out: the first time it fails."""
    return session.ended(f"{command} -q -p no:cacheprovider")[1]
