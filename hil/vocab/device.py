"""Device of a bench at run time: one face for a twin, a real board and a real drive.

An operation finds the device by its name and calls it. What a device cannot do it refuses itself, with a
``VerbRefused``. ``part``: name of the axis that is meant, or at ``type`` of the UART; empty: the first.
"""

from collections.abc import Callable, Coroutine, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any, Protocol

from hil.vocab.axis import Axis, AxisNow
from hil.vocab.desk_protocol import AxisLook, DeviceInfo, Done, Watch
from hil.vocab.faults import Fault
from hil.vocab.monitoring import HealthProblem
from hil.vocab.ports import EchoStats
from hil.vocab.verbs import VerbRefused

Doing = Done | Coroutine[Any, Any, Done]
"""Result of what is done at once, or when the device has confirmed it."""


class DeviceFaults(Protocol):
    """Faults of a real line, by their numbers: of bytes, from now on."""

    def inject(self, number: int, fault: Fault) -> None:
        """Begin a fault."""

    def clear(self, number: int) -> None:
        """End a fault."""

    def changed_bytes(self, number: int) -> int:
        """Number of bytes that a fault has changed."""


class ProcessorSession(Protocol):
    """Session of a GDB with a processor, from ``begin`` to ``close``."""

    def begin(self, send: Callable[[bytes], object], hang_up: Callable[[], object]) -> None:
        """Let the processor stand, and take GDB's packets from now on. ``hang_up``: sends GDB away when the
        device leaves the bench. Raises ConnectionError: another session was faster."""

    def received(self, data: bytes) -> bool:
        """Take bytes of GDB's; answers whether it has left."""

    def close(self) -> None:
        """End the session, and let the processor run."""


class DeviceProcessor(Protocol):
    """Processor of a device, which runs a user's program."""

    def look(self) -> dict[str, Any]:
        """Describe what is in it now; the keys are those of the operation ``processor``."""

    def load(self, program: bytes) -> Done:
        """Give it a program, as ``hil.sketch.chip_program.packed`` has it; the board starts again."""

    def count(self, starts: Sequence[int], lap_at: int | None) -> None:
        """Count from now on where its time goes: in functions, by their byte addresses, and from one time at
        an address to the next."""

    def counted(self) -> dict[str, Any]:
        """Cycles since then, those of functions, and those from one time to the next."""

    def debugging(self, stand: Callable[[bool], None]) -> ProcessorSession:
        """Make a session for GDB. ``stand``: called with true when the processor stands, and its group's time
        with it, and with false when it goes on.

        Raises:
            VerbRefused: it runs no program, or is debugged already.
        """


class Device(Protocol):
    """Device of a bench. It is made when the configuration names it, with all that its kind of board says;
    a reload that changes it makes another one."""

    @property
    def name(self) -> str: ...

    # ---- what it is ----

    def addresses(self) -> Iterator[str]:
        """Its own address, and those of its further axes."""

    def info(self, part: str) -> DeviceInfo:
        """Describe it with an axis: verbs, fields, pins. Raises KeyError: there is no such axis."""

    def no_axis(self) -> VerbRefused | None:
        """Refusal of what needs an axis that is seen; None: it has one."""

    # ---- what it can be told ----

    def do(self, part: str, verb: str, parameters: Mapping[str, float | str]) -> Doing:
        """Carry out a verb of its own table, with all parameters."""

    def reset(self) -> Doing:
        """Reset it."""

    def set(self, part: str, field: str, value: Any) -> Doing:
        """Set a field; answers its value."""

    def zero(self, part: str) -> Done:
        """Let the shaft's angle be 0 here; answers what it was, and the angle that the board itself counts,
        None for one that counts none or does not count now."""

    def pin(self, part: str, pin: str, level: int) -> Done:
        """Drive an input pin."""

    def processor(self) -> DeviceProcessor:
        """Processor that runs a user's program. Raises VerbRefused: it has none."""

    def drive(self, part: str, train: Sequence[Any]) -> Done:
        """Play a pulse train, rows of ``hil.wire.step_dir``; answers its length."""

    def type(self, part: str, data: bytes) -> Done:
        """Type bytes at a UART."""

    # ---- what it tells ----

    def state(self, part: str) -> dict[str, float | None]:
        """Fields now; None for what is no number, or is not told."""

    def packed(self, part: str) -> bytes:
        """The same in the binary layout."""

    def look(self, part: str) -> AxisLook:
        """The same, with what it means as motion."""

    async def wait(
        self,
        part: str,
        effective_at_ns: int,
        at_most_s: float,
        ends_after_ns: float | None,
        set_point: float | None,
    ) -> dict[str, bool]:
        """Wait until the motion that a verb began has ended; answers whether something else ended it."""

    def watch(
        self, part: str, interval_ns: int | Fraction, points: int, call: Callable[[bytes], object]
    ) -> Watch:
        """Begin to call with its fields, as ``Desk.watch``. Raises ValueError: nobody can have so much."""

    def signals(self, part: str, names: Sequence[str]) -> tuple[str, ...]:
        """Names of fields that are sampled; of none the usual ones. Raises ValueError: there are no such."""

    # ---- as an axis of runs ----

    def axes(self) -> Mapping[str, AxisNow]:
        """Axes by address, as a plan begins with them."""

    def axis(self, part: str) -> Axis:
        """An axis for a run."""

    # ---- how it does ----

    @property
    def is_there(self) -> bool | None:
        """True if the real thing can be reached; None: there is none."""

    @property
    def is_talking(self) -> bool:
        """True while it must not be exchanged: something is said to it step by step."""

    @property
    def where(self) -> str:
        """Place of the real thing in words, for who starts the bench; empty: there is none."""

    def counters(self) -> Mapping[str, int]:
        """Counters of requests to it; empty: nothing is asked of it."""

    def echoes(self) -> Iterable[tuple[str, EchoStats | None]]:
        """Echoes of its adapters, by the names of their places."""

    def listed(self, kinds: Mapping[str, str]) -> dict[str, Any]:
        """Own part of its row in ``list``. ``kinds``: of ports, by their labels."""

    def status(self) -> dict[str, Any]:
        """Further part of its row in ``status``."""

    def problems(self, is_service: bool) -> Iterator[HealthProblem]:
        """Present problems. ``is_service``: a service manager shuts hil off from devices."""

    @property
    def faults(self) -> DeviceFaults | None:
        """Faults of its real line; None: it has them in simulated time, or can have none."""

    # ---- its life ----

    async def begin(self) -> None:
        """Begin to reach the real thing, once it is in the bench."""

    def leave(self) -> None:
        """Leave the bench, in one step with others."""

    async def stop(self) -> None:
        """Stop what still moves by it, because the bench ends."""

    async def close(self) -> None:
        """Reach the real thing no more. The last call."""
