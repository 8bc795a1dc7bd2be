"""Keywords of Robot Framework at benches: ``Library    hil.robot    bench.yaml``.

``asked_keywords.py`` makes keywords of rows of the table of operations; ``port_keywords.py`` has those at
ports, ``program_keywords.py`` those of the program that is tested, ``axis_keywords.py`` those of time, axes
and packets. They work at a kind of bench: in memory on simulated time (``virtual_kind.py``), or in a process
in real time (``live_kind.py``). Each test has a bench of its own.

May import: hil.config, hil.operations.table, hil.sim, hil.testing, hil.vocab, the standard library,
robot, serial.

Tests may import too: device_profiles.
"""

from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path

from robot.api.deco import library

from hil import __version__
from hil.robot.asked_keywords import AskedKeywords
from hil.robot.axis_keywords import AxisKeywords
from hil.robot.bench_kind import BenchKind, refusals, suite_folder
from hil.robot.live_kind import real_boards, twins
from hil.robot.port_keywords import PortKeywords
from hil.robot.program_keywords import ProgramKeywords
from hil.robot.virtual_kind import VirtualKind
from hil.testing.given import NamedThings

KINDS: Mapping[str, Callable[[Path, int], BenchKind]] = {
    "virtual": VirtualKind,
    "live": lambda file, _: twins(file),
    "real": lambda file, _: real_boards(file),
}
"""Kinds of bench by name: called with the configuration's file and a seed."""


@library(scope="TEST", version=__version__, doc_format="ROBOT", listener="SELF", auto_keywords=True)
class RobotLibrary(PortKeywords, ProgramKeywords, AxisKeywords, AskedKeywords):
    """Keywords for tests of boards that hil emulates, and of programs that talk to them.

    | Library    hil.robot    bench.yaml
    | Library    hil.robot    bench.yaml    kind=live

    ``bench`` is the file of a configuration; its path begins in the folder of the suite. Each test has a
    bench of its own, which begins when a keyword first needs it, and as soon as all boards answer.

    - ``kind=virtual``: in memory. Simulated time passes only in keywords that wait: `Pass Time`, and those
      that have ``within``. The same tests and the same ``seed`` give the same bytes and times.
    - ``kind=live``: in a process of its own, in real time or at the ``speed`` of its configuration.
      ``seed`` has no meaning.
    - ``kind=real``: as ``live``, with a file whose devices have ``at:``, all or some: real boards.

    A test that its kind of bench cannot do is skipped, with the reason.

    An *address* is a device's name, as ``m1``, or that of a part of it: an axis (``arm.elbow``), a port
    (``s1.network``), a tap of a segment (``bus0.master``). Durations are as everywhere in Robot Framework:
    ``200 ms``, ``2 seconds``. They are of simulated time.
    """

    def __init__(
        self, bench: str = "bench.yaml", kind: str = "virtual", seed: int | str = 0
    ) -> None:  # Robot Framework 7.5 ends with a traceback if it cannot convert one of these: `_kind` does
        PortKeywords.__init__(self)
        ProgramKeywords.__init__(self)
        self._given = bench, kind, seed

    @cached_property
    def _kind(self) -> BenchKind:
        with refusals():
            file, kind, seed = self._given
            if not str(seed).isdecimal():
                raise ValueError(f"seed: write a whole number, not {seed!r}")
            return NamedThings("kind of bench", KINDS)[kind](suite_folder() / file, int(seed))

    def _close(self) -> None:
        """End the bench: Robot Framework calls it when the test is over."""
        if "_kind" in vars(self):
            self._kind.close()
