"""Places of a map's rows: which units and types they may have, and what they are."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from bridges.modbus.maps.map_row_models import NEW_KEYS, PlaceText
from bridges.modbus.protocol.pdu import Table
from bridges.modbus.registers.cells import BIT
from bridges.modbus.registers.drive_map import TYPES, RegisterPlace
from bridges.modbus.registers.map_parts import Conversion
from hil.config.document import Finding, KeyPath

ANGLE, SPEED, RAMP, CURRENT, OTHER = "an angle", "a speed", "a ramp", "a current", ""
UNITS: Mapping[str, Mapping[str, float]] = {
    ANGLE: {"deg": 1.0, "turn": 360.0, "rad": 57.29577951308232},
    SPEED: {"rpm": 1.0, "Hz": 60.0, "deg/s": 1 / 6, "turn/s": 60.0},
    RAMP: {"rpm/s": 1.0, "Hz/s": 60.0, "deg/s2": 1 / 6, "turn/s2": 60.0, "s": 1.0, "ms": 0.001},
    CURRENT: {"A": 1.0, "mA": 0.001},
}
"""Factors of units by quantity, to deg, rpm, rpm/s and A; of times to seconds."""
_TIMES, _PER_POLE = ("s", "ms"), ("Hz", "Hz/s")


def quantity_of(name: str) -> str:
    """Quantity of a value by the end of its name."""
    ends = {"_deg": ANGLE, "_rpm": SPEED, "_rpm_per_s": RAMP, "_A": CURRENT}
    return next((quantity for end, quantity in reversed(ends.items()) if name.endswith(end)), OTHER)


def place_of(
    name: str, text: PlaceText, table: Table, address: int, *, is_bit: bool, quantity: str | None = None
) -> RegisterPlace:
    """Place of a row. ``quantity``: None: that of its name."""
    if is_bit:
        on_write = bool(getattr(text, "on_write", False))
        return RegisterPlace(table, address, BIT, bit=text.bit, on_write=on_write)
    low_first = None if text.word_order is None else text.word_order == "low_first"
    return RegisterPlace(
        table,
        address,
        text.type,
        text.scale,
        mask=text.mask,
        count=text.registers or 1,
        low_first=low_first,
        conversion=_conversion(text, quantity_of(name) if quantity is None else quantity),
    )


def _conversion(text: PlaceText, quantity: str) -> Conversion | None:
    factor = UNITS[quantity].get(text.unit or "", 1.0) if quantity else 1.0
    if text.unit in _PER_POLE and quantity:
        factor /= text.pole_pairs or 1
    found = Conversion(
        1.0 if text.times is None else text.times,
        1.0 if text.per is None else text.per,
        text.decimals or 0.0,
        text.offset or 0.0,
        factor,
        text.to_rpm if text.unit in _TIMES and quantity == RAMP else None,
        text.at_zero,
    )
    if found == Conversion():
        return None
    parts = [text.unit or {ANGLE: "deg", SPEED: "rpm", RAMP: "rpm/s", CURRENT: "A"}.get(quantity, "")]
    parts += [f"x {_said(text.times)}"] if text.times is not None else []
    parts += [f"/ {_said(text.per)}"] if text.per is not None else []
    parts += [f"to {_said(text.to_rpm)} rpm"] if text.to_rpm is not None else []
    return replace(found, shown=" ".join(parts).strip())


def _said(factor: float | str) -> str:
    return factor if isinstance(factor, str) else f"{factor:g}"


def place_findings(path: KeyPath, text: PlaceText, *, is_bit: bool, quantity: str) -> Iterator[Finding]:
    """Findings of types, masks and units that contradict each other in one row."""
    given = text.model_fields_set
    if is_bit:
        for key in (key for key in NEW_KEYS if key not in ("pole_pairs", "to_rpm")):
            if key in given and getattr(text, key) is not None:
                yield Finding((*path, key), f"{path[-1]} is a bit, which has no {key}", "remove it", True)
        return
    if text.mask is not None and text.type not in ("u16",):
        what = f"a mask is of one register, and {text.type} is no number without a sign of one"
        yield Finding((*path, "mask"), what, "remove it, or the type")
    if text.type == "text" and text.registers is None:
        yield Finding(path, "a text has a number of registers", "add it, as in registers: 8")
    if text.type != "text" and text.registers is not None:
        yield Finding(
            (*path, "registers"), f"a {text.type} has its own number of registers", "remove it", True
        )
    yield from _unit_findings(path, text, quantity)


def _unit_findings(path: KeyPath, text: PlaceText, quantity: str) -> Iterator[Finding]:
    known = UNITS.get(quantity, {})
    if known and text.unit is not None and text.unit not in known:
        what = f"{path[-1]} is {quantity}, and {text.unit!r} is no unit of one"
        yield Finding((*path, "unit"), what, f"write {', '.join(known)}")
        return
    needs_poles = bool(known) and text.unit in _PER_POLE
    if needs_poles and text.pole_pairs is None:
        what = f"{text.unit} is no speed of a shaft without the pole pairs of the motor"
        yield Finding((*path, "unit"), what, "add them, as in pole_pairs: 2")
    if not needs_poles and text.pole_pairs is not None:
        what = f"pole pairs are for Hz, and the unit is {text.unit or 'none'}"
        yield Finding((*path, "pole_pairs"), what, "remove them, or write unit: Hz", at_key=True)
    is_time = quantity == RAMP and text.unit in _TIMES
    if is_time and text.to_rpm is None:
        what = f"a ramp in {text.unit} is the time to a speed, which is not given"
        yield Finding((*path, "unit"), what, "add the speed, as in to_rpm: 1500")
    if not is_time and text.to_rpm is not None:
        what = "to_rpm is for a ramp that is a time"
        yield Finding((*path, "to_rpm"), what, "remove it, or write unit: s", at_key=True)


def is_new(text: PlaceText) -> list[str]:
    """Keys of a row that version 2 has alone."""
    new = [key for key in NEW_KEYS if key in text.model_fields_set and getattr(text, key) is not None]
    return [*new, *(["type"] if text.type not in TYPES else [])]
