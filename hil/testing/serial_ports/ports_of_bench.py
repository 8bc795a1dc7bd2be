"""Ports of one bench for programs, by the names that it has for them."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import serial

from hil.config import BenchConfig, Catalogue
from hil.sim.bench import BenchRuntime
from hil.sim.twin import Twin
from hil.testing.given import NamedThings
from hil.testing.serial_ports.bench_serial import serial_class
from hil.testing.serial_ports.line_ends import LineEnd, TapEnd, UartEnd
from hil.testing.serial_ports.passing import OneThread, Passing
from hil.testing.serial_ports.port_lines import PortLines
from hil.testing.serial_ports.port_terminal import PortTerminal
from hil.testing.serial_ports.system_calls import SystemCalls
from hil.vocab.time import FOREVER, SimTimeNs

USUAL_BAUD = 115_200
"""Speed of ports at which bytes take no time."""
_KINDS_WITH_LINES = ("rfc2217", "usb")


class SerialPorts:
    """Ports of a bench. ``advance``: lets time pass until a line is heard; ``passed``: called with the time
    when a wait at a port has let it pass, and at ``stop_ns`` at the latest."""

    def __init__(
        self,
        runtime: BenchRuntime,
        config: BenchConfig,
        catalogue: Catalogue,
        advance: Callable[[SimTimeNs, list[LineEnd]], object],
        passed: Callable[[SimTimeNs], None],
        stop_ns: Callable[[], SimTimeNs],
    ) -> None:
        self.bench = config.bench
        self._runtime, self._config, self._catalogue = runtime, config, catalogue
        self._advance, self._passed, self._stop_ns = advance, passed, stop_ns

    @cached_property
    def terminals(self) -> dict[str, PortTerminal]:
        """Terminals by addresses, as ``m1``, ``s1.network``, ``bus0.master``."""
        runtime, made = self._runtime, dict[str, PortTerminal]()
        for name, device in runtime.devices.items():
            for uart in device.uarts:
                label = device.uarts.label(name, uart)
                made[label] = self._at_uart(label, device, uart)
        for name, tap in runtime.taps.items():
            made[name] = PortTerminal(name, TapEnd(runtime, tap))
        return made

    def _at_uart(self, label: str, device: Twin, uart: str) -> PortTerminal:
        config, name = self._config.devices[device.name], device.uarts.short(uart)
        identity = config.usb_identity(self._catalogue.profiles[config.profile], name)
        is_native = identity.is_native
        kind = port.kind if (port := config.port_of(name)) else ""
        end = UartEnd(self._runtime, device, uart, resets=is_native and kind != "usb")
        touched = end.reset if is_native and kind == "usb" else None
        lines = PortLines(end, touched) if kind in _KINDS_WITH_LINES else None
        made = PortTerminal(label, end, lines)
        made.identity = identity
        return made

    @cached_property
    def passing(self) -> Passing:
        """Time as a test's only thread lets it pass."""
        return OneThread(self._runtime, self._advance, self._open_ends, self._passed, self._stop_ns)

    def _open_ends(self) -> list[LineEnd]:
        return [each.end for each in self.terminals.values() if each.opens]

    @cached_property
    def serial_class(self) -> type[serial.Serial]:
        """Class of pyserial for these ports, at which a test's only thread waits."""
        return self.class_for(self.passing, self.terminals)

    def class_for(
        self, passing: Passing, terminals: Mapping[str, PortTerminal], *, has_map: bool = False
    ) -> type[serial.Serial]:
        """Make a class of pyserial for some ports. ``passing``: how time passes for those who wait;
        ``has_map``: names can be given to ports by --map."""
        return serial_class(SystemCalls(passing, terminals, has_map))

    def named(self, mapped: Mapping[str, str]) -> dict[str, PortTerminal]:
        """Terminals by their addresses, and by further paths that have names of ports. Raises KeyError."""
        ports = NamedThings("port", self.terminals)
        return self.terminals | {path: ports[name] for path, name in mapped.items()}

    @property
    def due_ns(self) -> SimTimeNs:
        """Time at which something happens by itself at a port; ``FOREVER``: at none."""
        made: dict[str, PortTerminal] = vars(self).get("terminals", {})
        return min((each.due_ns for each in made.values()), default=FOREVER)

    def descriptors(self) -> set[int]:
        """File descriptors that programs have for these ports now."""
        return {each.descriptor() for each in self.terminals.values() if each.is_watched}

    def open(self, name: str, baudrate: int | None, options: dict[str, Any]) -> serial.Serial:
        """Open a port at its own speed, unless another is given. Raises KeyError: there is none."""
        __tracebackhide__ = True
        NamedThings("port", self.terminals)[name]
        given = () if baudrate is None else (baudrate,)
        return self.maker(name)(name, *given, **options)

    def maker(self, name: str) -> Callable[..., serial.Serial]:
        """Function that makes a port's ``Serial`` as its class does, but at the line's own speed by default.
        Raises KeyError: there is no such port."""
        own_baud = self.terminals[name].end.baud or USUAL_BAUD

        def make(port: str | None, *given: Any, **options: Any) -> serial.Serial:
            if not given:
                options.setdefault("baudrate", own_baud)
            return self.serial_class(port, *given, **options)

        return make

    def passed(self, now_ns: SimTimeNs) -> None:
        """Note that time has passed, for terminals in use."""
        if "terminals" in vars(self):
            for each in self.terminals.values():
                if each.opens or each.due_ns <= now_ns:
                    each.passed(now_ns)
