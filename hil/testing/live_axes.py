"""Axes, boards and faults of a bench that is served, as tests of any kind of bench use them."""

from collections.abc import Mapping
from typing import Any, Literal

from hil.core import Snapshot
from hil.sim.given_fault import fault_refusal
from hil.testing.faces import AxisFace, DeviceFace, FaultFace
from hil.testing.live_desk import LiveDesk
from hil.testing.unsupported import RealTimeFace, UnsupportedHere
from hil.vocab.address import Address, owner_of, pin_of
from hil.vocab.faults import FAULT_KINDS, PORT, FaultRefused
from hil.vocab.verbs import VerbRefused


class LiveFace(RealTimeFace):
    """Face of a part of a bench, which is asked at its desk. ``face``: that of the bench in memory."""

    face: type

    def __init__(self, name: str, desk: LiveDesk) -> None:
        self._name, self._desk = name, desk

    @property
    def kind(self) -> str:  # type: ignore[override]
        return self._desk.kind

    def _virtual(self) -> tuple[type, frozenset[str]]:
        return self.face, frozenset()

    def _ask(self, verb: str, **arguments: Any) -> Any:
        __tracebackhide__ = True
        return self._desk.do(verb, self._name, device=self._name, **arguments)

    def _set(self, verb: str, **arguments: Any) -> None:
        """Ask for what a bench in memory refuses with a ValueError."""
        __tracebackhide__ = True
        try:
            self._ask(verb, **arguments)
        except VerbRefused as error:
            raise ValueError(str(error)) from None

    def do(self, verb: str, **parameters: float | str) -> dict[str, Any]:
        """Carry out a verb of the board's table (``hil axis NAME`` lists it), now; answers its result, and
        ``effective_at_ns``.

        Raises:
            VerbRefused: it was not carried out; ``code`` and text say why.
        """
        __tracebackhide__ = True
        answer: dict[str, Any] = self._ask("do", name=verb.replace("-", "_"), parameters=parameters)
        return answer


class LiveAxis(LiveFace):
    """Axis of a device."""

    face = AxisFace

    def snapshot(self) -> Snapshot:
        """State now, as far as it is told."""
        __tracebackhide__ = True
        state = self._ask("state")
        values = [float("nan") if value is None else value for value in state.values()]
        return Snapshot(values, {name: index for index, name in enumerate(state)})

    def set(self, field: str, value: float) -> None:
        """Set a field from outside, as `hil set` does. Raises ValueError: it cannot be set, or not to
        this."""
        __tracebackhide__ = True
        self._set("set", field=field, value=value)

    def zero(self) -> None:
        """Let the shaft's angle, ``position_deg``, be 0 from now on where the shaft is. Raises ValueError: it
        cannot be now."""
        __tracebackhide__ = True
        self._set("zero")

    @property
    def load_torque_Nm(self) -> float:
        """External torque on the shaft with that of faults, positive towards larger counts. Raises
        ValueError: it is set to more than the motor can have."""
        torque_Nm: float = self.snapshot().load_torque_Nm
        return torque_Nm

    @load_torque_Nm.setter
    def load_torque_Nm(self, torque_Nm: float) -> None:
        __tracebackhide__ = True
        self._set("set", field="load_torque_Nm", value=torque_Nm)


class LiveDevice(LiveFace):
    """Board from outside: what an operator's hand can do to it."""

    face = DeviceFace

    @property
    def failed(self) -> str | None:
        """Reason why the device has stopped, or None."""
        failed: str | None = self._desk.status(self._name)["failed"]
        return failed

    def pin(self, name: str, level: int) -> None:
        """Drive an input, of another axis than the first as in ``elbow.step``."""
        __tracebackhide__ = True
        axis, pin = pin_of(name)
        target = str(Address(self._name, axis)) if axis else self._name
        try:
            self._desk.do("pin", target, device=target, pin=pin, level=level)
        except VerbRefused as error:
            raise ValueError(str(error)) from None

    def set_register(self, name: Literal["diaagc", "errfl"], value: int) -> None:
        """Set a register of the encoder, 0 to 0x7FFF. Raises ValueError: it cannot be."""
        __tracebackhide__ = True
        self._set("set", field=name, value=value)

    def reset(self) -> None:
        """Switch the power off and on; a real board is reset at its terminal."""
        __tracebackhide__ = True
        self._ask("reset")


class LiveFault(RealTimeFace):
    """Fault that was injected; as a context it is cleared at the end."""

    def __init__(self, desk: LiveDesk, kind: str, target: str, parameters: Mapping[str, float | str]) -> None:
        __tracebackhide__ = True
        self._desk = desk
        if FAULT_KINDS.get(kind) and owner_of(target) in desk.real:
            _check_real(desk, kind, target, parameters)
        asked = {"fault": kind, "target": target, "parameters": dict(parameters)}
        try:
            self.number: int = desk.do("inject", target, **asked)["number"]
        except VerbRefused as error:
            raise _refused(desk, target, error) from None

    @property
    def kind(self) -> str:  # type: ignore[override]
        return self._desk.kind

    def _virtual(self) -> tuple[type, frozenset[str]]:
        return FaultFace, frozenset()

    @property
    def is_active(self) -> bool:
        """True until the fault has ended, also before it begins."""
        return any(row["number"] == self.number for row in self._desk.ask("faults"))

    def clear(self) -> None:
        """End the fault; nothing if it has ended."""
        if self.is_active:
            self._desk.ask("clear", number=self.number)

    def __enter__(self) -> "LiveFault":
        return self

    def __exit__(self, *_: object) -> None:
        self.clear()


def _refused(desk: LiveDesk, target: str, error: VerbRefused) -> Exception:
    """Refusal of a fault, as a bench in memory has it; at a real board or drive, or at a target that is of
    the test's own bench alone, as what this kind cannot do."""
    if owner_of(target) in desk.real:
        return UnsupportedHere(desk.kind, str(error))
    return desk.lacking(target) or FaultRefused(str(error))


def is_drive(at: str) -> bool:
    """True for the place of a real drive on a bus, as ``modbus+tcp://...``."""
    return "+" in at.partition("://")[0] and "://" in at


def _check_real(desk: LiveDesk, kind: str, target: str, parameters: Mapping[str, float | str]) -> None:
    """Check a fault of a real board: it can have those of bytes on its line, from now on.

    Raises:
        FaultRefused: a parameter does not do.
        UnsupportedHere: no real board can have it.
    """
    fault = fault_refusal(kind, target, parameters)
    about, on_lines = FAULT_KINDS[kind], [each for each in FAULT_KINDS.values() if each.target == PORT]
    if about not in on_lines or target not in desk.real:
        why = f"{owner_of(target)} is real, and hil cannot give it {kind} ({about.about})"
        here = ", ".join(each.name for each in on_lines)
        on_line = "" if is_drive(desk.real[owner_of(target)]) else f"; its line can have {here}"
        raise UnsupportedHere(desk.kind, why + on_line)
    if is_drive(desk.real[target]):
        raise UnsupportedHere(desk.kind, f"{target} is a real drive: hil sees no bytes on its line")
    if fault.number("start_s") or fault.number("for_s"):
        why = f"{target} is a real board: its line has a fault from now on until it is cleared"
        raise UnsupportedHere(desk.kind, f"{why}, without start_s and for_s")
