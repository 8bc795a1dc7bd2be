"""Message of ``hil serve`` when everything serves."""

import os
import shlex
import shutil
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from hil import __version__
from hil.cli.bench.port_views import HINT
from hil.cli.framework.shown_words import first_keys, reached_at
from hil.config.port_kinds import port_kinds
from hil.daemon import Serving
from hil.host.journal import is_journal
from hil.host.log_writer import LogWriter
from hil.host.paths import runtime_base
from hil.net.benches_here import find
from hil.vocab.address import address_of, owner_of
from hil.vocab.firmware import NETWORK
from hil.vocab.port_programs import is_held, port_use

_PROGRAM_S = 3
"""Time in which a program of a user's says something: a bootloader listens for 1.5 s before it."""


def started(serving: Serving, writer: LogWriter, runtime: Path | None = None) -> None:
    """Write the message, after what is in the log already. Without a standard output nobody is told.
    ``runtime``: folder of the benches, if commands have to be told it."""
    try:
        fd = sys.stdout.fileno()
    except (OSError, ValueError):
        return
    text = "\n".join(_lines(serving, is_journal(sys.stdout, os.environ), runtime))
    writer.write(fd, text + "\n")


def _lines(serving: Serving, for_journal: bool, runtime: Path | None) -> list[str]:
    config, catalogue = serving.live.configured.config, serving.live.configured.catalogue
    lines = [f"hil {__version__}  bench {config.bench}  {serving.grant.line()}"]
    if for_journal:  # nobody types from there
        for name, address in serving.live.places.addresses():
            lines.append(f"{name} at {address}")
        return lines
    options = _options(runtime, config.bench)
    axis = shlex.join(["hil", *options, "axis"])
    kinds = port_kinds(config)
    for name, session in serving.live.places.items():
        address, twin = session.port.address, owner_of(name)
        if twin not in serving.live.sim.devices:
            continue
        device = config.devices[twin]
        profile = catalogue.profiles[device.profile]
        place = f"the other end of {address}" if is_held(kinds[name]) else address
        if name != twin:
            uart = address_of(name).part
            speed = device.uart_bauds(profile)[uart]
            speaks = f", {speed} baud" if speed else ""
            speaks += ", packets" if uart == NETWORK else ""
            lines.append(f"  {name} at {place}{speaks}")
            continue
        has_program = serving.live.sim.devices[twin].has_program
        greeting = "" if has_program else profile.greeting
        own, wait_s = "runs its program, which sets the speed", _PROGRAM_S if has_program else 1
        ready = own if has_program else f"answers {profile.ready_after_s:g} s after power-up"
        keys, head = first_keys(greeting), f"\n{name}: {device.profile} at {place}, {ready}"
        lines.append(f"{head}, then is silent until you {keys}" if keys else head)
        if not is_held(kinds[name]):
            monitor = shlex.join([_hil(), *options, "monitor", name])
            lines += client_lines(monitor, address, device.baud or 115200, greeting, wait_s)
    for name, each in serving.live.sim.devices.items():
        if not each.uarts:
            lines.append(f"\n{name}: {each.profile}, without a serial port; {axis} {name}")
    for name, tap in serving.live.places.items():
        if owner_of(name) not in serving.live.sim.wires:
            continue
        place = f"the other end of {tap.port.address}" if is_held(kinds[name]) else tap.port.address
        lines.append(f"\n{name}: tap at {place}, {tap.backend.tap.speed}")
    for name, wire in serving.live.sim.wires.items():
        if about := wire.about(serving.live.sim.cards_on(wire)):
            lines.append(f"\n{name}: {about}")
    for name, at in serving.live.devices.items():
        if at.where:
            seen = f"; {axis} {name}" if at.info("").is_seen else ""
            lines.append(f"\n{name}: {at.where}{seen}")
    for kind, bridge in serving.live.bridges.items():
        status = bridge.status()
        lines.append(f"\n{kind}: {reached_at(status)}")
        if status["insecure"]:
            lines.append(
                f"  insecure: {status.get('risk', 'every program that can reach it may do everything')}"
            )
    uses = (port_use(kinds[name], address) for name, address in serving.live.places.addresses())
    lines += ["", *([HINT, ""] if any(uses) else []), "Ctrl-C ends the bench."]
    return lines


def client_lines(monitor: str, address: str, baud: int, greeting: str, timeout_s: int = 1) -> Iterator[str]:
    """Commands that reach a port. ``timeout_s``: time in which the board says something."""
    scheme, is_url, place = address.rpartition("://")
    yield f"  {monitor}"
    if scheme == "rfc2217":
        host, _, number = place.rpartition(":")
        yield f"  telnet {host.strip('[]')} {number}"
    if not is_url:
        yield f"  picocom -b {baud} {address}"
    client = f"serial.serial_for_url('{address}', {baud}, timeout={timeout_s})"
    typed = f"s.write({greeting.encode()!r}); " if greeting else ""
    yield f'  {sys.executable} -c "import serial; s = {client}; {typed}print(s.read(99))"'


def _options(runtime: Path | None, bench: str) -> list[str]:
    """Options with which commands ask this bench, as long as no other one is started."""
    default = runtime_base(None, None, os.environ)
    other = None if runtime == default else runtime
    return find(other, os.environ).running().options((runtime or default) / bench, other, os.environ)


def _hil() -> str:
    """This hil as a shell finds it: by its name, or by a path, short where it is below this folder."""
    own, known = Path(sys.executable).with_name("hil"), shutil.which("hil")
    if not own.exists() or (known and own.samefile(known)):
        return "hil"
    with suppress(ValueError, OSError):  # it is elsewhere; this folder is gone
        return str(own.relative_to(Path.cwd()))
    return str(own)
