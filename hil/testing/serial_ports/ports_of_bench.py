"""Ports of one bench for programs, by the names that it has for them."""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import serial

from hil.config import BenchConfig, Catalogue
from hil.sim.bench import BenchRuntime
from hil.testing.given import NamedThings
from hil.testing.serial_ports.bench_serial import serial_class
from hil.testing.serial_ports.line_ends import LineEnd, TapEnd, UartEnd
from hil.testing.serial_ports.passing import OneThread, Passing
from hil.testing.serial_ports.port_terminal import PortTerminal
from hil.testing.serial_ports.system_calls import SystemCalls
from hil.vocab.time import SimTimeNs

USUAL_BAUD = 115_200
"""Speed of ports at which bytes take no time."""
_KINDS_WITH_LINES = ("rfc2217", "usb")


class SerialPorts:
    """Ports of a bench. ``passed``: called with the time when a wait at a port has let it pass, at least once
    in ``slice_ns``, unless that is None."""

    def __init__(
        self,
        runtime: BenchRuntime,
        config: BenchConfig,
        catalogue: Catalogue,
        passed: Callable[[SimTimeNs], None],
        slice_ns: Callable[[], int | None],
    ) -> None:
        self._runtime, self._config, self._catalogue = runtime, config, catalogue
        self._passed, self._slice_ns = passed, slice_ns

    @cached_property
    def terminals(self) -> dict[str, PortTerminal]:
        """Terminals by addresses, as ``m1``, ``s1.network``, ``bus0.master``."""
        runtime, made = self._runtime, dict[str, PortTerminal]()
        for name, device in runtime.devices.items():
            is_native = self._catalogue.profiles[self._config.devices[name].profile].usb == "native"
            for uart in device.uarts:
                label = device.uarts.label(name, uart)
                end = UartEnd(runtime, device, uart, is_native)
                made[label] = PortTerminal(
                    label, end, has_lines=self._has_lines(name, device.uarts.short(uart))
                )
        for name, tap in runtime.taps.items():
            made[name] = PortTerminal(name, TapEnd(runtime, tap), has_lines=False)
        return made

    def _has_lines(self, device: str, uart: str) -> bool:
        ports = self._config.devices[device].ports
        return uart in ports and ports[uart].kind in _KINDS_WITH_LINES

    @cached_property
    def passing(self) -> Passing:
        """Time as a test's only thread lets it pass."""
        return OneThread(self._runtime, self._open_ends, self._passed, self._slice_ns)

    def _open_ends(self) -> list[LineEnd]:
        return [each.end for each in self.terminals.values() if each.opens]

    @cached_property
    def serial_class(self) -> type[serial.Serial]:
        """Class of pyserial for these ports, at which a test's only thread waits."""
        return self.class_for(self.passing, self.terminals)

    def class_for(self, passing: Passing, terminals: Mapping[str, PortTerminal]) -> type[serial.Serial]:
        """Make a class of pyserial for some ports. ``passing``: how time passes for those who wait."""
        return serial_class(SystemCalls(passing, terminals))

    def named(self, mapped: Mapping[str, str]) -> dict[str, PortTerminal]:
        """Terminals by their addresses, and by further paths that have names of ports. Raises KeyError."""
        ports = NamedThings("port", self.terminals)
        return self.terminals | {path: ports[name] for path, name in mapped.items()}

    def descriptors(self) -> set[int]:
        """File descriptors that programs have for these ports now."""
        return {each.descriptor() for each in self.terminals.values() if each.is_watched}

    def open(self, name: str, baudrate: int | None, options: dict[str, Any]) -> serial.Serial:
        """Open a port at its own speed, unless another is given. Raises KeyError: there is none."""
        __tracebackhide__ = True
        terminal = NamedThings("port", self.terminals)[name]
        return self.serial_class(name, baudrate or terminal.end.baud or USUAL_BAUD, **options)

    def passed(self, now_ns: SimTimeNs) -> None:
        """Note that time has passed, for terminals in use."""
        if "terminals" in vars(self):
            for each in self.terminals.values():
                if each.opens:
                    each.passed(now_ns)
