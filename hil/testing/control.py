"""A control law over recorded encoder counts, without plant, firmware or time."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hil.core import _native
from hil.core.fields import INDEX

if TYPE_CHECKING:
    import numpy as np

LAWS = ("mechaduino",)
_TYPES = {
    "raw": "int32",
    "r": "float32",
    "mode": "int32",
    "y_meas": "float32",
    "y_excite": "float32",
    "yw": "float32",
    "e": "float32",
    "ITerm": "float32",
    "DTerm": "float32",
    "v": "float32",
    "u": "float32",
    "U": "int32",
    "vref1": "int16",
    "vref2": "int16",
    "in1": "int8",
    "in2": "int8",
    "in3": "int8",
    "in4": "int8",
    "wrap_count": "int32",
    "led": "int8",
}


def replay_control(
    law: str,
    raw: Sequence[int],
    r: Sequence[float],
    mode: Sequence[int | str],
    table: Sequence[float],
    gains: Mapping[str, float],
    gain_changes: Iterable[tuple[int, str, float]] = (),
) -> "dict[str, np.ndarray[Any, Any]]":
    """Run a law from zeroed state, one row for each control step: its inputs and everything it computes.

    ``raw`` encoder counts, ``r`` set-points and ``mode`` (letters, or their codes; 0 none) have one entry a
    step; ``table`` is the look-up table, 16,384 angles in degrees; ``gains`` has any of pKp pKi pKd pLPF vKp
    vKi vKd vLPF PA uMAX; ``gain_changes`` are (step, name, value), in force from that step on. Answers numpy
    columns: raw, r, mode, y_meas, y_excite (with the phase advance), yw, e, ITerm, DTerm, v, u, U, vref1,
    vref2, in1 to in4, wrap_count, led; float32 exact.

    Raises:
        ValueError: an unknown law, or columns of different lengths.
        KeyError, AttributeError: no such gain.
    """
    import numpy as np

    if law not in LAWS:
        raise ValueError(f"no law {law!r}; there are {', '.join(LAWS)}")
    if not len(raw) == len(r) == len(mode):
        raise ValueError(f"columns differ in length: raw {len(raw)}, r {len(r)}, mode {len(mode)}")
    replay = _native.Replay(np.asarray(table, dtype=np.float32).tobytes())
    for name, value in gains.items():
        replay.set(INDEX[name], value)
    changes: dict[int, list[tuple[str, float]]] = {}
    for step, name, value in gain_changes:
        changes.setdefault(int(step), []).append((name, value))
    columns: dict[str, list[float]] = {name: [] for name in _TYPES}
    for step, (count, setpoint, letter) in enumerate(zip(raw, r, mode, strict=True)):
        for name, value in changes.get(step, ()):
            replay.set(INDEX[name], float(value))
        code = ord(letter) if isinstance(letter, str) else int(letter)
        replay.set(INDEX["r"], float(setpoint))
        replay.set(INDEX["mode"], code)
        row = {"raw": int(count), "r": float(setpoint), "mode": code} | dict(replay.step(int(count)))
        for name, values in columns.items():
            values.append(row[name])  # type: ignore[arg-type]
    return {name: np.array(values, dtype=_TYPES[name]) for name, values in columns.items()}
