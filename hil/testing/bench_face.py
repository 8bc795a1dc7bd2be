"""Calls that all kinds of bench have: in memory (``Bench``), in a process (``ServedBench``), real boards."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Protocol, overload

from hil.core import Snapshot


class AnyPort(Protocol):
    """Port of a device."""

    def write(self, data: bytes, client_baud: int | None = None) -> None:
        """Send bytes to the device, now."""

    def read(self) -> bytes:
        """Read everything the device has sent since the last call."""

    def read_timed(self) -> list[tuple[Any, bytes]]:
        """Read as ``read``: pieces with the simulated times, in ns, at which they were sent."""


class AnyTap(Protocol):
    """Tap on a segment or a bus."""

    def write(self, data: bytes) -> None:
        """Send bytes on the wire, now, or when what was written before has gone out."""

    def read(self) -> bytes:
        """Read what was complete on the wire since the last call."""


class AnyFault(Protocol):
    """Fault that was injected; as a context it is cleared at the end."""

    number: int

    @property
    def is_active(self) -> bool:
        """True until the fault has ended, also before it begins."""

    def clear(self) -> None:
        """End the fault; nothing if it has ended."""

    def __enter__(self) -> Any: ...

    def __exit__(self, *_: object) -> None: ...


class AnyAxis(Protocol):
    """Axis of a device."""

    load_torque_Nm: float

    def snapshot(self) -> Snapshot:
        """State now."""

    def do(self, verb: str, **parameters: float | str) -> dict[str, Any]:
        """Carry out a verb of the board, now. Raises VerbRefused: it was not carried out."""

    def set(self, field: str, value: float) -> None:
        """Set a field from outside, as `hil set` does. Raises ValueError: it cannot be set, or not to
        this."""

    def zero(self) -> None:
        """Let the shaft's angle be 0 where it is. Raises ValueError: it cannot be now."""


class AnyDevice(Protocol):
    """Board from outside."""

    @property
    def failed(self) -> str | None:
        """Reason why the device has stopped, or None."""

    def do(self, verb: str, **parameters: float | str) -> dict[str, Any]:
        """Carry out a verb of the board, now. Raises VerbRefused: it was not carried out."""

    def pin(self, name: str, level: int) -> object:
        """Drive an input."""

    def reset(self) -> None:
        """Switch the power off and on; a real board is reset at its terminal."""


class AnyBench(Protocol):
    """Bench of any kind. What one kind cannot do raises ``UnsupportedHere``, which skips the test in pytest.
    A name that is not there raises KeyError. All times are of the bench, in ms or ns: in memory they pass in
    these calls alone, elsewhere always."""

    @property
    def kind(self) -> str:
        """``virtual``, ``live`` or ``real``."""

    @property
    def now_ns(self) -> int:
        """Simulated time since the bench's start."""

    def start(self) -> list[str]:
        """Wait until the boards answer; answers the names of those that do not."""

    def run(self, ms: float) -> None:
        """Let time pass."""

    def run_until(self, ms: float) -> None:
        """Let time pass until it is so many milliseconds since the bench's start."""

    @overload
    def wait_until(self, condition: Callable[[], object], /, *, within_ms: float = ...) -> int: ...

    @overload
    def wait_until(self, axis: str, condition: str, /, *, within_ms: float = ...) -> int: ...

    def wait_until(
        self, condition: Callable[[], object] | str, of_axis: str = "", /, *, within_ms: float = 10_000
    ) -> int:
        """Let time pass until a condition holds. Raises NotInTime: it does not."""

    def port(self, name: str) -> AnyPort:
        """Port of a device, as ``m1`` or ``s1.network``."""

    def serial(self, name: str, baudrate: int | None = None, **options: Any) -> Any:
        """Open a port or a tap as pyserial's ``Serial``."""

    def tap(self, name: str) -> AnyTap:
        """Tap of a segment or a bus, as ``bus0.master``."""

    def can(self, name: str = "can0") -> Any:
        """CAN bus, with a node of the test's own on it."""

    def modbus(self, **options: Any) -> Any:
        """Connect pymodbus's ``ModbusTcpClient`` to the Modbus bridge of the configuration."""

    def zenoh(self) -> Any:
        """Open a session, as zenoh's ``Session``, at the zenoh bridge of the configuration."""

    def axis(self, name: str) -> AnyAxis:
        """Axis at an address, as ``m1`` or ``arm.elbow``."""

    def device(self, name: str) -> AnyDevice:
        """Board by its name."""

    def fault(self, kind: str, target: str, **parameters: float | str) -> AnyFault:
        """Make something go wrong, until it is cleared. Raises FaultRefused, a VerbRefused: it cannot be."""

    def capture(self, file: Path | str) -> AbstractContextManager[object]:
        """Capture the traffic of all ports and lines into a file, as pcapng, for a ``with`` block."""
