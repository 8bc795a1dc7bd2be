"""Files of a test that failed, for who looks later: ``pytest --hil-artifacts DIR``."""

import re
import time
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from hil import __version__
from hil.telemetry.picture import PictureError, drawn
from hil.testing.failures.bench_account import Section
from hil.testing.failures.bench_replay import BenchReplay, replay_bench
from hil.testing.failures.bench_traffic import as_pcapng, port_records
from hil.testing.failures.failure_page import KeptFile, failure_page
from hil.vocab.address import owner_of
from hil.wire.pcapng import whole_blocks

if TYPE_CHECKING:
    from hil.testing.bench import Bench
    from hil.testing.served_bench import ServedBench

LONGEST_NAME = 120
"""Maximum length of a folder's name; of a longer one there are the beginning and a checksum."""
MOST_PICTURES = 12
"""Maximum number of axes of a bench that are drawn, some 0.3 s each: first those with faults, then those that
move."""
PAGE = "failure.html"
FLUSHED_S = 0.3
"""Time after which a daemon's recording has what has happened."""


def folder_name(node_id: str) -> str:
    """Name of a folder for a test, made from its node's: letters, digits and ``._-[]`` alone."""
    name = re.sub(r"[^\w.\[\]]+", "-", node_id, flags=re.ASCII)
    name = name.strip(".-")
    if len(name) <= LONGEST_NAME and name:
        return name
    return f"{name[:LONGEST_NAME]}-{zlib.crc32(node_id.encode()):08x}"


class FailureFolder:
    """Folder of a test that failed. What was there of an earlier run is replaced."""

    def __init__(self, artifacts: Path, node_id: str) -> None:
        self.path = artifacts / folder_name(node_id)
        self._node_id = node_id
        self._files: list[KeptFile] = []
        self._sections: list[Section] = []
        self._number = 0
        self.path.mkdir(parents=True, exist_ok=True)

    def add_sections(self, sections: Iterable[Section]) -> None:
        """Have sections of the report in the page, too."""
        self._sections += sections

    def add_bench(self, bench: "Bench") -> Iterator[Section]:
        """Keep the input log of a bench in memory, its traffic, and pictures of its axes' last two seconds;
        says what of it is not as it should be.

        Raises:
            ConfigError, InputLogError: as ``hil.compose.replay.replay``.
            OSError: there is no room.
        """
        mark, name = self._next_mark(), bench.config.bench
        log = self._new(f"inputs{mark}.jsonl", f"input log of {name}: hil replay runs it again")
        with log.open("w", encoding="utf-8") as file:
            bench.inputs.write_to(file)
        again = replay_bench(bench.inputs, bench.now_ns, _drawn_axes(bench))
        records = [*port_records(bench.inputs, bench.runtime), *again.wire_records]
        traffic = self._new(f"traffic{mark}.pcapng", f"traffic of {name}: hil decode, Wireshark")
        traffic.write_bytes(as_pcapng(records, f"hil {__version__}"))
        if again.difference:
            yield f"{log.name} does not replay as it ran", again.difference
        yield from self._draw(mark, again, f"the last two seconds, up to {bench.now_ns / 1e9:.6f} s")

    def _draw(self, mark: str, again: BenchReplay, when: str) -> Iterator[Section]:
        for axis, recording in again.recordings.items():
            try:
                picture = drawn({axis: recording}, ".svg", f"{axis}: {when}")
            except PictureError as error:
                yield "no pictures", str(error)
                return
            self._new(f"{axis}{mark}.svg", f"{axis}: where it was and should have been, and its currents")
            self._files[-1].path.write_bytes(picture)

    def add_live(self, bench: "ServedBench") -> Iterator[Section]:
        """Keep what the daemon of a live bench has said, its traffic, and its recording."""
        mark, name = self._next_mark(), bench.info.get("bench", "live")
        if bench.log_file.exists():
            log = self._new(f"hil{mark}.log", f"log of hil serve {name}")
            log.write_bytes(bench.log_file.read_bytes())
        if bench.capture_file.exists():
            capture = bench.capture_file.read_bytes()
            kept = self._new(f"capture{mark}.pcapng", f"traffic of {name}: hil decode, Wireshark")
            kept.write_bytes(capture[: whole_blocks(capture)])
        if bench.recording_file.exists():
            time.sleep(FLUSHED_S)  # what led to the failure has to be in it
            recording = self._new(f"run{mark}.hil.gz", f"recording of {name}: hil replay runs it again")
            recording.write_bytes(bench.recording_file.read_bytes())
        yield from ()

    def write_page(self, failure: str) -> Path:
        """Write the page that has all of it; ``failure``: what pytest says of it."""
        page = self.path / PAGE
        page.write_text(failure_page(self._node_id, failure, self._sections, self._files), encoding="utf-8")
        return page

    def _next_mark(self) -> str:
        """Mark of the next bench in names of files: none of the first."""
        self._number += 1
        return f"-{self._number}" if self._number > 1 else ""

    def _new(self, name: str, about: str) -> Path:
        self._files.append(KeptFile(self.path / name, about))
        return self.path / name


def _drawn_axes(bench: "Bench") -> list[str]:
    """Addresses of the axes to draw."""
    runtime = bench.runtime
    faulty = {fault.target for fault in runtime.faults.active.values()}

    def rank(address: str) -> int:
        axis = runtime.parts.axis(address)
        state = axis.kind.motion(axis.snapshot())
        return 0 if faulty & {address, owner_of(address)} else 1 if state.is_moving else 2

    there = [address for address in runtime.parts.axes if runtime.parts.axis(address).kind.has_motor]
    return sorted(there, key=rank)[:MOST_PICTURES]
