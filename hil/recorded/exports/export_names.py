"""Names that an export is of: fields of axes, pins and lines, ports and wires."""

from collections.abc import Collection, Sequence

from hil.core.axis_kind import AxisKind
from hil.recorded.exports.run_records import record_sources
from hil.recorded.recorded_fields import RunField, parse_fields
from hil.recorded.recorded_run import RecordedRun
from hil.vocab.near_words import meant

_MORE = ("position_deg", "velocity_rpm", "e", "load_torque_Nm")
"""Fields that plots of a whole run want beside those that a drawing has by default."""


class NoSuchSignal(ValueError):
    """Error of a name that is nothing which this format has: ``str(error)`` says what is like it."""


def usual_fields(kind: AxisKind, *, more: bool = False) -> list[str]:
    """Fields of an axis of which nobody names one."""
    wanted = (*kind.default_signals, *(_MORE if more else ()))
    return [*dict.fromkeys(name for name in wanted if name in kind.fields)]


def wanted_fields(run: RecordedRun, names: Sequence[str], *, more: bool = False) -> list[RunField]:
    """Fields that are named; an axis alone means its usual ones, no name those of all axes.

    Raises:
        NoSuchField: there is none of this name.
    """
    parts = run.runtime.parts
    kinds = {address: device.axes[name].kind for address, (device, name) in parts.axes.items()}
    fields: list[RunField] = []
    for name in names or kinds:
        if (address := parts.axis_address(name)) is not None:
            fields += [RunField(address, each) for each in usual_fields(kinds[address], more=more)]
        else:
            fields += parse_fields(run.runtime, [name])
    return [*dict.fromkeys(fields)]


def wanted_of(names: Sequence[str], known: Collection[str], what: str) -> list[str]:
    """Names of ``known`` that are meant: by themselves, or all below a name, as ``m1`` or ``m1.*``; no name
    means all. ``what``: word for them.

    Raises:
        NoSuchSignal: there is none of this name.
    """
    found: list[str] = []
    for name in names:
        below = [each for each in known if each == name or each.startswith(f"{name.removesuffix('.*')}.")]
        if not below:
            raise NoSuchSignal(f"there is no {what} {name!r}; {meant(name, [*known])}")
        found += [name] if name in known else below
    return [*dict.fromkeys(found)] if names else [*known]


def wanted_of_all(run: RecordedRun, names: Sequence[str]) -> tuple[list[RunField], list[str]]:
    """Fields, and ports and wires, that are named; no name means all that is usual.

    Raises:
        NoSuchField: a name is neither.
    """
    sources = record_sources(run.runtime)
    if not names:
        return wanted_fields(run, (), more=True), [*sources]
    parts = run.runtime.parts
    of_axes = [name for name in names if name not in sources or parts.axis_address(name) is not None]
    fields = wanted_fields(run, of_axes, more=True) if of_axes else []
    return fields, [*dict.fromkeys(name for name in names if name in sources)]
