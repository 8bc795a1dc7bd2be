"""Places of lines: a tap of a bench that runs here, by its name, or the address of a port."""

import os
import time
from dataclasses import dataclass
from pathlib import Path

from hil.discovery.board_loading import Boards
from hil.discovery.board_places import find_places
from hil.host.trust import refuse_address
from hil.net.benches_here import Here, find
from hil.net.control_client import ControlError, ask
from hil.vocab.line_node import LineNodes
from hil.vocab.near_words import meant
from hil.vocab.port_programs import is_held
from hil.vocab.problem import ConfigError
from hil.vocab.time import NS_PER_MS
from hil.wire.bytes_framing import BYTES

LATENCY_NS = {"tap": 25 * NS_PER_MS, "path": 35 * NS_PER_MS, "network": 60 * NS_PER_MS}
"""Maximum delay there and back, unless somebody says another: a bench on a busy computer; a USB adapter,
which may hold bytes for 16 ms; a network in a house, and a server of ports behind it."""

NOTICE_S, LOOK_S = 10.0, 0.02
"""Time in which a bench notices that its tap is open, and the interval of looks."""


class LineUnreachable(Exception):
    """Error of a line that there is not, or that cannot be opened: ``str(error)`` says why.
    ``is_mistake``: true if a retry does not help."""

    def __init__(self, why: str, *, is_mistake: bool = True) -> None:
        super().__init__(why)
        self.is_mistake = is_mistake


@dataclass(frozen=True)
class LinePlace:
    """Place of a line: ``name`` as it was given, ``address`` that can be opened. ``speed``: simulated time
    that passes in a second, of a bench's tap; ``latency_ns`` is simulated, too."""

    name: str
    address: str
    nodes: LineNodes
    baud: int
    latency_ns: int
    speed: float = 1.0
    has_bit_times: bool = True
    """False for a pty that is no bench's: who is at its other end may answer at once."""
    control: Path | None = None
    """Control socket of the tap's bench."""
    echo: bool | None = None
    """True if its adapter echoes what is sent; None: recognised by itself."""

    def wait_until_heard(self) -> None:
        """Wait as ``wait_until_heard`` does, where the line is a tap."""
        if self.control is not None:
            wait_until_heard(self.name, self.control)


def wait_until_heard(name: str, control: Path) -> None:
    """Wait until the bench hears who has opened its tap: it drops what came before it has noticed.

    Raises:
        LineUnreachable: the bench does not answer any more, or does not notice within ``NOTICE_S``.
    """
    until_s = time.monotonic() + NOTICE_S
    while True:
        try:
            taps = {row["tap"]: row for row in ask(control, "list")["taps"]}
        except ControlError as error:
            raise LineUnreachable(str(error), is_mistake=False) from None
        if name in taps and taps[name]["clients"]:
            return
        if time.monotonic() > until_s:
            raise LineUnreachable(f"{name}: its bench does not hear this program", is_mistake=False)
        time.sleep(LOOK_S)


def find_line(
    line: str,
    *,
    baud: int | None = None,
    latency_ns: int | None = None,
    profile: str | None = None,
    echo: bool | None = None,
    bench: str | None = None,
    runtime_dir: Path | None = None,
) -> LinePlace:
    """Find a line: ``bus0.master`` is a tap of the bench that runs here, ``/dev/ttyUSB0``,
    ``socket://host:port`` and ``rfc2217://host:port`` are ports. ``latency_ns``: maximum delay there and
    back, on this computer's clock; ``profile``: kind of its nodes, needed where several kinds have a master;
    ``echo``: whether its adapter echoes, None: recognised by itself.

    Raises:
        LineUnreachable: there is none.
    """
    if is_address(line):
        nodes = nodes_of(profile)
        kind = "path" if line.startswith("/") else "network"
        latency_ns = _or(latency_ns, LATENCY_NS[kind])
        is_pty = os.path.realpath(line).startswith("/dev/pts/")
        return LinePlace(
            line, line, nodes, baud or nodes.baud, latency_ns, has_bit_times=not is_pty, echo=echo
        )
    here = bench_here(line, bench, runtime_dir)
    return tap_place(here, line, baud=baud, latency_ns=latency_ns, profile=profile, echo=echo)


def bench_here(line: str, bench: str | None, runtime_dir: Path | None) -> Here:
    """Find the bench that a tap is of. Raises LineUnreachable: none runs here, or several."""
    found = find(runtime_dir, os.environ).running()
    benches = found.meant(bench or os.environ.get("HIL_BENCH") or None)
    if len(benches) != 1:
        names = ", ".join(found.called(each) for each in benches)
        why = f"several benches are running: {names}" if benches else found.none_runs()
        raise LineUnreachable(f"{line}: {why}", is_mistake=bool(benches))
    return benches[0]


def is_address(line: str) -> bool:
    """True if a line is an address of a port; else it is the name of a tap."""
    return line.startswith("/") or "://" in line


def tap_place(
    bench: Here,
    name: str,
    *,
    baud: int | None = None,
    latency_ns: int | None = None,
    profile: str | None = None,
    echo: bool | None = None,
) -> LinePlace:
    """Find a tap of a bench. Raises LineUnreachable: it has no such tap, or does not answer."""
    tap = bench_tap(bench, name)
    nodes = nodes_of(profile, tap.framing, tap.profiles)
    return LinePlace(
        name,
        tap.address,
        nodes,
        baud or tap.baud or nodes.baud,
        round(_or(latency_ns, LATENCY_NS["tap"]) * tap.speed),
        tap.speed,
        control=bench.socket,
        echo=echo,
    )


@dataclass(frozen=True)
class BenchTap:
    """Tap of a running bench, whatever its line speaks. ``speed``: simulated time that passes in a second."""

    address: str
    baud: int | None
    framing: str | None
    profiles: list[str]
    speed: float


def bench_tap(bench: Here, name: str) -> BenchTap:
    """Ask a bench for its tap. Raises LineUnreachable: it has no such tap, or does not answer."""
    try:
        listed = ask(bench.socket, "list")
        segments = ask(bench.socket, "segments")
        speed = float(ask(bench.socket, "status")["speed"])
    except ControlError as error:
        raise LineUnreachable(str(error), is_mistake=error.is_mistake) from None
    taps = {tap["tap"]: (tap, row) for row in segments for tap in row["taps"]}
    if name not in taps:
        there = meant(name, list(taps)) if taps else "it has none: `taps:` of a segment makes one"
        raise LineUnreachable(f"bench {listed['bench']} has no tap {name!r} of a segment; {there}")
    tap, row = taps[name]
    kind = next(each["kind"] for each in listed["taps"] if each["tap"] == name)
    if is_held(kind):
        raise LineUnreachable(f"{name} is at the other end of {tap['address']}: hil itself has this end open")
    if why := refuse_address(tap["address"], bench.owner):
        raise LineUnreachable(f"{tap['address']!r}, which the bench gave as a port's address: {why}")
    profiles = [each["profile"] for each in listed["devices"]]
    return BenchTap(
        tap["address"],
        tap.get("baud"),
        row.get("framing"),
        profiles,
        speed,
    )


def nodes_of(profile: str | None, framing: str | None = None, likely: list[str] | None = None) -> LineNodes:
    """Nodes of a kind: of a profile, or of the one profile that has a master for its line. ``framing``: name
    of the line's; ``likely``: profiles of boards that may be on it.

    Raises:
        LineUnreachable: there is no such profile, or none with a master, or several.
    """
    if framing == BYTES.name:  # of a line of which nobody said what it speaks
        framing = None
    places = find_places()
    usable = [name for name in sorted(places.places) if name not in places.refused]
    boards = Boards(places.places, usable)
    if profile is not None:
        if profile not in boards:
            raise LineUnreachable(f"there is no profile {profile!r}; {meant(profile, usable)}")
        if (nodes := _nodes(boards, profile)) is None:
            raise LineUnreachable(f"hil has no master for lines of {profile}")
        return nodes
    first = [name for name in dict.fromkeys(likely or ()) if name in boards]
    for names in (first, usable):
        found = {name: nodes for name in names if (nodes := _nodes(boards, name))}
        found = {name: each for name, each in found.items() if framing in (None, each.framing.name)}
        if len(found) == 1:
            return next(iter(found.values()))
        if found:
            raise LineUnreachable(f"several kinds of nodes may be on this line: {', '.join(found)}")
    raise LineUnreachable(f"hil has no master for a line with the framing {framing}")


def _nodes(boards: Boards, name: str) -> LineNodes | None:
    try:
        return boards[name].line_nodes
    except ConfigError:
        return None  # a board that cannot be used is no reason to leave out others


def _or(given: int | None, usual: int) -> int:
    return usual if given is None else given
