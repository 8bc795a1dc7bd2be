"""Everything that can be made to go wrong, in one table that configuration, commands and reference use."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class FaultParameter:
    """A number or a choice that a kind of fault takes."""

    name: str
    about: str
    unit: str = ""
    minimum: float = 0.0
    maximum: float = 1.0
    default: float | str | None = None
    """None: it has to be given."""
    choices: tuple[str, ...] = ()
    """Not empty: one of these words instead of a number."""

    def problem(self, value: object) -> str | None:
        """What is wrong with a value, or None."""
        if self.choices:
            return None if value in self.choices else f"write {' or '.join(self.choices)}"
        if isinstance(value, bool) or not isinstance(value, int | float):
            return "write a number"
        if not self.minimum <= value <= self.maximum:
            return f"write {self.minimum:g} to {self.maximum:g}"
        return None


@dataclass(frozen=True)
class FaultKind:
    """One thing that goes wrong: its layer (byte, packet, node, physics, host) and what it can be on."""

    name: str
    layer: str
    targets: str
    about: str
    parameters: tuple[FaultParameter, ...]


_RATE = FaultParameter("rate", "probability for each byte", default=None)
_TOWARDS = FaultParameter("towards", "which way the bytes go", default="client", choices=("board", "client"))
_SEED = FaultParameter("seed", "where its chance starts", maximum=2**63, default=0)

FAULT_KINDS: Mapping[str, FaultKind] = {
    kind.name: kind
    for kind in (
        FaultKind(
            "byte_flip",
            "byte",
            "device",
            "bits of bytes are inverted",
            (FaultParameter("rate", "probability for each bit", default=None), _TOWARDS, _SEED),
        ),
        FaultKind("byte_drop", "byte", "device", "bytes are lost", (_RATE, _TOWARDS, _SEED)),
        FaultKind("byte_duplicate", "byte", "device", "bytes come twice", (_RATE, _TOWARDS, _SEED)),
        FaultKind(
            "byte_delay",
            "byte",
            "device",
            "bytes come late, and those behind them too",
            (
                _RATE,
                FaultParameter("delay_ms", "how late", "ms", 0.0, 60_000.0, default=10.0),
                _TOWARDS,
                _SEED,
            ),
        ),
    )
}


@dataclass(frozen=True)
class Fault:
    """A fault of a kind, with all its parameters."""

    kind: str
    target: str
    parameters: Mapping[str, float | str] = field(default_factory=dict)


def fault_of(kind: str, target: str, given: Mapping[str, object]) -> tuple[Fault | None, dict[str, str]]:
    """The fault with its kind's defaults filled in, or what is wrong, by the name of the parameter (the
    kind's own name under "fault")."""
    known = FAULT_KINDS.get(kind)
    if known is None:
        return None, {"fault": f"kinds are {', '.join(FAULT_KINDS)}"}
    problems: dict[str, str] = {}
    parameters: dict[str, float | str] = {}
    names = {parameter.name: parameter for parameter in known.parameters}
    for name in given:
        if name not in names:
            problems[name] = f"parameters of {kind} are {', '.join(names)}"
    for name, parameter in names.items():
        value = given.get(name, parameter.default)
        if value is None:
            problems[name] = f"this one is missing: {parameter.about}"
        elif problem := parameter.problem(value):
            problems[name] = problem
        elif isinstance(value, int | float | str):
            parameters[name] = value
    return (None, problems) if problems else (Fault(kind, target, parameters), {})
