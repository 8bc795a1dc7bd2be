"""Bench in a process of its own, in real time, behind real ports: for tests of programs that know nothing of
hil, and as all kinds of bench."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from functools import cached_property
from pathlib import Path
from typing import Any

import serial

from hil.compose import find_catalogue
from hil.testing.given import NamedThings, checked_bytes
from hil.testing.live_axes import LiveAxis, LiveDevice, LiveFault
from hil.testing.live_desk import ANSWER_S, LiveDesk, LiveError
from hil.testing.live_ports import Hearing, LivePort, LiveTap
from hil.testing.live_traffic import LiveCapture, LiveTraffic, sources
from hil.testing.serial_ports.ports_of_bench import USUAL_BAUD
from hil.testing.served_doors import ZENOH, modbus_client, zenoh_session
from hil.testing.served_program import ServedProgram
from hil.testing.unsupported import RealTimeFace, UnsupportedHere
from hil.testing.waiting import WITHIN_MS, wait_until
from hil.vocab.time import NS_PER_MS

READY_S = 120.0
"""Maximum time until the boards answer, by default: many that start at once have to wait for a CPU."""
_MAIN = "import sys; sys.argv[0] = 'hil'; from hil.cli.entry import main; main()"
HIL = (sys.executable, "-P", "-c", _MAIN)
"""Command of this installation, whatever a shell finds, and whatever is in the current folder."""
RECORDING = "run.hil.gz"
"""Name of the recording's file in the folder of what is kept, unless the options say something else."""
SHOWN_LINES = 40
ATTRIBUTES = frozenset({"arrivals", "chance", "config", "inputs", "more_sections", "seed"})
"""Public attributes of a bench in memory, beside those of its class."""
OPEN: "list[ServedBench]" = []
"""Benches that run, for the reports of tests that fail."""


class ServedBench(RealTimeFace):
    """Bench in a process of its own. ``folder`` has its ports and memories, ``kept`` log, capture, recording.

    Long because it has all calls of a bench of any kind, and those at a process, one short method each.
    """

    def __init__(self, process: subprocess.Popen[bytes], folder: Path, kept: Path) -> None:
        self._process = process
        self.folder = folder
        self.log_file = kept / "hil.log"
        self.capture_file = kept / "capture.pcapng"
        self.recording_file = kept / RECORDING
        self.info: Mapping[str, Any] = {}
        """Report of ``hil serve --json`` from when the boards answered; the reference has its keys."""
        self.programs: list[ServedProgram] = []
        """Programs that ran beside it."""
        self.absent: Callable[[str], str] = lambda name: ""
        """Answers why the bench lacks a name that the test's own configuration has, or an empty text."""
        self.traffic: LiveTraffic | None = None
        """Traffic since the boards answered, if it is captured."""
        self._open = ExitStack()
        self._taps: dict[str, LiveTap] = {}
        self._buses: dict[str, Any] = {}

    @property
    def pid(self) -> int:
        """Process of ``hil serve``."""
        return self._process.pid

    @property
    def ports(self) -> Mapping[str, str]:
        """Paths and URLs of all ports by address: ``m1``, ``s1.network``, ``bus0.master``."""
        return NamedThings("port", self.info["ports"])

    @cached_property
    def desk(self) -> LiveDesk:
        """Control socket, with refusals as a bench in memory has them."""
        return LiveDesk(Path(self.info["control"]), lambda name: self.absent(name))

    @property
    def kind(self) -> str:  # type: ignore[override]
        """``live``, or ``real`` with a real board."""
        return self.desk.kind

    def _virtual(self) -> tuple[type, frozenset[str]]:
        from hil.testing.bench import Bench

        return Bench, ATTRIBUTES

    # ---- as all kinds of bench ----

    @property
    def now_ns(self) -> int:
        """Simulated time since the bench's start."""
        return self.desk.now_ns

    def start(self) -> list[str]:
        """Answer the names of real boards that cannot be reached: the twins answer when a bench is there."""
        return [*self.away()]

    def away(self) -> dict[str, str]:
        """Reasons why real boards cannot be reached, by their names."""
        problems = self.ask("health").get("problems", [])
        drives = {row["device"]: row["drive"] for row in self.ask("status")["devices"] if "drive" in row}
        late = {
            name: f"{self.desk.real[name]}: no answer yet"
            for name, drive in drives.items()
            if drive["state"] != "there"
        }
        return late | {
            row["about"]: f"{row['what']}; {row['remedy'].partition(';')[0]}"
            for row in problems
            if row["kind"] == "port" and row["about"] in self.desk.real
        }

    def run(self, ms: float) -> None:
        """Let at least ``ms`` milliseconds of simulated time pass."""
        self.run_until(self.now_ns / NS_PER_MS + ms)

    def run_until(self, ms: float) -> None:
        """Let time pass until the simulated time is ``ms`` milliseconds, or more if it is later already."""
        while (left_ms := ms - self.now_ns / NS_PER_MS) > 0:
            time.sleep(left_ms / 1000 / self.info["speed"])

    def wait_until(
        self, condition: Callable[[], object] | str, of_axis: str = "", /, *, within_ms: float = WITHIN_MS
    ) -> int:
        """Let time pass until a condition holds, as ``Bench.wait_until``; it is looked at each few
        milliseconds of this computer's time. Raises NotInTime: it does not hold in simulated time."""
        __tracebackhide__ = True
        return wait_until(self, condition, of_axis, within_ms)

    def port(self, name: str) -> LivePort:
        """Port at an address, which is its path or URL, too, as pyserial's ``serial_for_url`` takes it.
        Raises KeyError: with the names that there are."""
        __tracebackhide__ = True
        return LivePort(self._address(name), name, self.desk, Hearing(name, self._heard))

    def _address(self, name: str) -> str:
        __tracebackhide__ = True
        try:
            return self.ports[name]
        except KeyError as error:
            raise self.desk.no_port(name, str(error)) from None

    def _heard(self) -> LiveTraffic:
        if self.traffic is None:
            self.traffic = LiveTraffic(self.desk, sources(self.desk))
            self._open.callback(self.traffic.close)
        return self.traffic

    def serial(self, name: str, baudrate: int | None = None, **options: Any) -> serial.Serial:
        """Open a port or a tap as pyserial's ``Serial``, until the bench ends at the latest. Time-outs are of
        this computer's time. ``baudrate``: the line's own by default. Raises KeyError: there is none."""
        __tracebackhide__ = True
        baud = baudrate or self.info["bauds"].get(name) or USUAL_BAUD
        opened = serial.serial_for_url(self._address(name), baud, **options)
        self._open.callback(opened.close)
        return opened

    def tap(self, name: str) -> LiveTap:
        """Tap by its name, as in ``bus0.master``. Raises KeyError: there is none."""
        __tracebackhide__ = True
        if name not in self._taps:
            self._address(name)
            heard = self.hear(name)
            self._taps[name] = LiveTap(name, self.desk, Hearing(name, lambda: heard))
        return self._taps[name]

    def hear(self, name: str) -> LiveTraffic:
        """Hear a tap or a wire from now on, until the bench ends."""
        heard = LiveTraffic(self.desk, [name])
        self._open.callback(heard.close)
        return heard

    def can(self, name: str = "can0") -> Any:
        """CAN bus by its name, with a node of the test's own on it from the first call on. Raises KeyError:
        there is none."""
        __tracebackhide__ = True
        if name not in self._buses:
            kinds = find_catalogue({}).wire_kinds
            make = next((kind.kit.served_face for kind in kinds if kind.key == "can" and kind.kit), None)
            if make is None:
                raise UnsupportedHere(self.kind, "no CAN is installed")
            self._buses[name] = make(self, name)
        return self._buses[name]

    def modbus(self, name: str = "", **options: Any) -> Any:
        """Connect pymodbus's ``ModbusTcpClient``, whose ``options`` these are, to the bench's Modbus bridge,
        or with the path of one of its serial lines a ``ModbusSerialClient``, until the bench ends at the
        latest.

        Raises:
            KeyError: the configuration has no Modbus bridge, or that has no such line.
        """
        __tracebackhide__ = True
        listens = self.info["bridges"].get("modbus")
        if listens is None:
            why = "the bench has no bridge modbus; write `bridges: {modbus: {}}` into its configuration"
            raise self.desk.no_such("modbus", why)
        client = modbus_client(listens, name, options)
        self._open.callback(client.close)
        return client

    def zenoh(self) -> Any:
        """Open a session of zenoh at the bench's bridge, until the bench ends at the latest.

        Raises:
            KeyError: the configuration has no such bridge.
            UnsupportedHere: it needs certificates.
        """
        __tracebackhide__ = True
        listens = self.info["bridges"].get("zenoh")
        if listens is None:
            why = "the bench has no bridge zenoh; write `bridges: {zenoh: {}}` into its configuration"
            raise self.desk.no_such("zenoh", why)
        if not (addresses := [each for each in listens if each.startswith(ZENOH)]):
            raise UnsupportedHere(
                self.kind, "its zenoh bridge does not listen at tcp/ (bridges.zenoh.listen)"
            )
        session = zenoh_session(addresses[0])
        self._open.callback(session.close)
        return session

    def axis(self, name: str) -> LiveAxis:
        """Axis at an address, as in ``m1`` or ``arm.elbow``. Raises KeyError: there is none."""
        __tracebackhide__ = True
        self.desk.do("verbs", name, device=name)
        return LiveAxis(name, self.desk)

    def device(self, name: str) -> LiveDevice:
        """Board by its name. Raises KeyError: there is none."""
        __tracebackhide__ = True
        self.desk.status(name)
        return LiveDevice(name, self.desk)

    def fault(self, kind: str, target: str, **parameters: float | str) -> LiveFault:
        """Make something go wrong (``hil.vocab.faults`` has the kinds), until it is cleared.

        Raises:
            FaultRefused: there is no such kind or target, or a parameter does not do.
        """
        __tracebackhide__ = True
        return LiveFault(self.desk, kind, target, parameters)

    def capture(self, file: Path | str) -> LiveCapture:
        """Capture all ports and lines into a file, as pcapng, for a ``with`` block."""
        return LiveCapture(self.desk, Path(file))

    def close(self) -> None:
        """Close what the test has left open. The process ends with its ``with`` block or fixture."""
        self._open.close()

    # ---- as a process ----

    @property
    def log(self) -> str:
        """Log of the daemon so far."""
        return self.log_file.read_text(errors="replace")

    def ask(self, verb: str, **arguments: Any) -> Any:
        """Ask at the control socket, as in ``ask("inject", fault="packet_nak", target="s4.network",
        parameters={})``; the reference has its verbs. Raises LiveError: it was refused."""
        __tracebackhide__ = True
        return self.desk.ask(verb, **arguments)

    def hil(self, *arguments: str, timeout_s: float = READY_S) -> str:
        """Run a command on this bench, as in ``hil("fault", "clear")``; answers what it printed. Raises
        LiveError: it exits with another code than 0."""
        __tracebackhide__ = True
        command = [*HIL, *arguments, "--runtime-dir", str(self.folder / "run")]
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout_s, check=False)
        if done.returncode:
            raise LiveError(f"hil {' '.join(arguments)}: exit code {done.returncode}\n{done.stderr}")
        return done.stdout

    def type(self, name: str, *lines: bytes, until: bytes, timeout_s: float = ANSWER_S) -> bytes:
        """Send lines to a port, and read after each up to ``until``; answers all that came. Raises LiveError:
        it did not come in time; TypeError: something is not bytes."""
        __tracebackhide__ = True
        lines, until = tuple(map(checked_bytes, lines)), checked_bytes(until)
        heard, address = b"", self.port(name)
        baud = self.info["bauds"][name] or 115200
        with serial.serial_for_url(address, baud, timeout=timeout_s) as port:
            for line in lines:
                port.write(line)
                heard += (answer := port.read_until(until))
                if not answer.endswith(until):
                    raise LiveError(
                        f"{name} did not answer {until!r} to {line!r} in {timeout_s:g} s: {answer!r}"
                    )
        return heard

    def program(
        self,
        words: Sequence[str | os.PathLike[str]],
        map: Mapping[str, str] | None = None,
        **options: Any,
    ) -> ServedProgram:
        """Run a program beside this bench, until its end or the bench's. A word that is the name of a port,
        or is one of ``map``, which has names of ports by such words, is given to it as the port's path.

        Raises:
            KeyError: there is no such port.
            OSError: it cannot be run.
        """
        __tracebackhide__ = True
        self.programs.append(ServedProgram(self.ports, words, map or {}, self.info["speed"], options))
        return self.programs[-1]

    def end_programs(self) -> None:
        """End the programs that still run beside it."""
        for each in self.programs:
            each.close()

    def report(self) -> list[tuple[str, str]]:
        """Titles and texts for the report of a test that failed: the ends of the log and of the traffic,
        in words."""
        name = self.info.get("bench", "live")
        sections = [(f"hil serve {name} ({self.log_file})", end_of(self.log))]
        if self.capture_file.exists():
            decode = [*HIL, "decode", str(self.capture_file)]
            text = subprocess.run(decode, capture_output=True, text=True, timeout=READY_S, check=False).stdout
            if text:
                sections.append((f"traffic of {name} ({self.capture_file})", end_of(text)))
        return [*sections, *(section for each in self.programs for section in each.sections())]

    def state_now(self) -> list[tuple[str, str]]:
        """Title and text for such a report, too: time, boards and faults as they are now."""
        return [(f"{self.info.get('bench', 'live')} now, by hil status", self.hil("status").strip("\n"))]


def end_of(text: str) -> str:
    """The last lines of a text."""
    lines = text.splitlines()
    left_out = [f"... {len(lines) - SHOWN_LINES} lines before"] if len(lines) > SHOWN_LINES else []
    return "\n".join([*left_out, *lines[-SHOWN_LINES:]]) or "nothing"
