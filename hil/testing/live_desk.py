"""Requests to a bench that is served, with refusals as the bench in memory has them."""

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

from hil.net.control_client import ControlError, ask
from hil.testing.given import NoSuchName, no_such
from hil.testing.unsupported import UnsupportedHere
from hil.vocab.address import owner_of
from hil.vocab.verbs import VerbRefused

ANSWER_S = 60.0
"""Maximum time for an answer: of twenty benches that start at once on two CPUs each waits for its turns."""


class LiveError(Exception):
    """Error of a live bench: ``str(error)`` is what ``hil`` said."""


class LiveDesk:
    """Control socket of a bench. ``absent``: answers why the bench lacks a name that the test's own
    configuration has, or an empty text."""

    def __init__(self, control: Path, absent: Callable[[str], str] = lambda name: "") -> None:
        self.control = control
        self._absent = absent

    def ask(self, verb: str, **arguments: Any) -> Any:
        """Ask. Raises LiveError: it was refused."""
        __tracebackhide__ = True
        try:
            return ask(self.control, verb, timeout_s=ANSWER_S, **arguments)
        except ControlError as error:
            raise LiveError(str(error)) from None

    def do(self, verb: str, of: str = "", **arguments: Any) -> Any:
        """Ask about what is called ``of``.

        Raises:
            KeyError: there is no such thing.
            UnsupportedHere: a real board cannot do it.
            VerbRefused: it was refused otherwise.
            LiveError: there is no answer.
        """
        __tracebackhide__ = True
        try:
            return ask(self.control, verb, timeout_s=ANSWER_S, **arguments)
        except ControlError as error:
            if error.code in ("no_device", "no_place"):
                raise self.no_such(of, str(error)) from None
            if error.code == "cannot" and owner_of(of) in self.real:
                raise UnsupportedHere(self.kind, str(error)) from None
            if error.code:
                raise VerbRefused(error.code, str(error)) from None
            raise LiveError(str(error)) from None

    def no_such(self, name: str, why: str) -> Exception:
        """Error of a name that is not there: a refusal of this kind, if the test's own configuration has
        it."""
        return self.lacking(name) or NoSuchName(why)

    def lacking(self, name: str) -> UnsupportedHere | None:
        """Refusal of a name that the test's own configuration has and this bench lacks; None: it is none."""
        absent = self._absent(name)
        return UnsupportedHere(self.kind, absent) if absent else None

    def no_port(self, name: str, why: str) -> Exception:
        """Error of a port that is not there, as ``no_such``; a serial interface without one is refused."""
        try:
            self.do("send", name, device=name, data="")
        except KeyError:
            return self.no_such(name, why)
        except (UnsupportedHere, VerbRefused) as error:
            return error
        why = f"{name} has no port: it is on a segment or a bus; look at it by a tap, or b.capture"
        return UnsupportedHere(self.kind, why)

    @cached_property
    def real(self) -> dict[str, str]:
        """Places of real boards by their names."""
        rows = self.ask("list")["devices"]
        return {row["device"]: row["at"] for row in rows if row["hardware"] == "real"}

    @property
    def kind(self) -> str:
        """``real`` with a real board, ``live`` otherwise."""
        return "real" if self.real else "live"

    @property
    def now_ns(self) -> int:
        """Simulated time since the bench's start."""
        now_ns: int = self.ask("status")["sim_ns"]
        return now_ns

    def status(self, device: str) -> dict[str, Any]:
        """Row of a device. Raises KeyError: there is none."""
        __tracebackhide__ = True
        rows = {row["device"]: row for row in self.ask("status")["devices"]}
        if device not in rows:
            raise self.no_such(device, str(no_such("device", device, rows)))
        found: dict[str, Any] = rows[device]
        return found
