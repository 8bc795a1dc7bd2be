"""pyserial's ``Serial`` on a bench: its own code, with the calls of the system answered by the bench."""

import types
from typing import Any

import serial
from serial import serialutil

from hil.testing.serial_ports.system_calls import CLOCK_START_S, SystemCalls, modules_for
from hil.vocab.time import NS_PER_S


def serial_class(calls: SystemCalls) -> type[serial.Serial]:
    """Make the class for a bench. Each function of pyserial's class and its bases is made again with other
    globals; nothing of pyserial's own changes."""

    class Timeout(serialutil.Timeout):
        @staticmethod
        def TIME() -> float:
            return CLOCK_START_S + calls.passing.now_ns / NS_PER_S

    class Sleeping:
        @staticmethod
        def sleep(seconds: float) -> None:
            calls.passing.wait(lambda: False, calls.end_of(seconds), "sleep", None)

    ours = {**modules_for(calls), "Timeout": Timeout, "time": Sleeping}
    members: dict[str, Any] = {}
    for base in reversed(serial.Serial.__mro__):
        if base.__module__.partition(".")[0] == "serial":
            members |= {name: _again(each, ours) for name, each in vars(base).items() if _is_code(each)}
    members |= {"fileno": _fileno(calls), "peek": _peek(calls)}
    return type("Serial", (serial.Serial,), {**members, "__module__": "serial", "__doc__": None})


def _is_code(member: Any) -> bool:
    return isinstance(member, types.FunctionType | property)


def _again(member: Any, ours: dict[str, Any]) -> Any:
    if isinstance(member, property):
        return property(*(each and _again(each, ours) for each in (member.fget, member.fset, member.fdel)))
    names = {**member.__globals__, **ours}
    made = types.FunctionType(
        member.__code__, names, member.__name__, member.__defaults__, member.__closure__
    )
    made.__kwdefaults__ = member.__kwdefaults__
    made.__doc__ = member.__doc__
    return made


def _fileno(calls: SystemCalls) -> Any:
    def fileno(self: Any) -> int:
        """File descriptor for ``select``: readable while there is something to read."""
        if not self.is_open:
            raise serialutil.PortNotOpenError()
        return calls.terminal(self.fd).descriptor()

    return fileno


def _peek(calls: SystemCalls) -> Any:
    def peek(self: Any, size: int = 0) -> bytes:
        """Bytes that have come, which stay: Python's ``readline`` reads as many of them at once as it may."""
        return calls.terminal(self.fd).peek(calls.passing.now_ns) if self.is_open else b""

    return peek
