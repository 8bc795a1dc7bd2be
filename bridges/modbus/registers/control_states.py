"""States of CiA 402 behind a control word and a status word that are registers (IEC 61800-7-201, 7-301)."""

from collections.abc import Callable
from typing import Protocol


class StatesNow(Protocol):
    """State of a drive, as ``bridges.modbus.registers.map_now.MapNow``."""

    @property
    def mode(self) -> str:
        """Meaning of its mode."""

    def kept(self, name: str) -> float:
        """Content of a cell."""

    def holds(self, condition: str) -> bool:
        """True if a condition holds."""


STATE = "cia402.state"
"""Name of the cell that has the state while the drive is off."""
DISABLED, READY, SWITCHED_ON = 0, 1, 2
_SWITCH_ON, _VOLTAGE, _NO_QUICK_STOP, _OPERATE = 1, 2, 4, 8
_NEW_SET_POINT, _RELATIVE, _RESET, _HALT = 1 << 4, 1 << 6, 1 << 7, 1 << 8
_WORDS = {DISABLED: 0x0040, READY: 0x0031, SWITCHED_ON: 0x0033}
_OPERATION, _FAULT = 0x0037, 0x0008
_REMOTE, _REACHED, _ACKNOWLEDGED = 1 << 9, 1 << 10, 1 << 12
_ATTAINED, _HOMING_ERROR = 1 << 12, 1 << 13


def status_word(now: StatesNow) -> int:
    """Status word of a drive now."""
    is_on = now.holds("enabled")
    word = _OPERATION if is_on else _WORDS.get(int(now.kept(STATE)), 0)
    if now.holds("fault"):
        word = _FAULT
    word |= _REMOTE | (_REACHED if is_on and _has_reached(now) else 0)
    if now.mode == "search_home":
        word |= _ATTAINED if now.holds("homed") else _HOMING_ERROR if now.holds("home_missed") else 0
    is_position = now.mode in ("absolute", "relative")
    if now.mode == "home" and is_on and now.holds("homed"):
        word |= _ACKNOWLEDGED
    return word | (_ACKNOWLEDGED if is_position and is_on and _last(now) & _NEW_SET_POINT else 0)


def _has_reached(now: StatesNow) -> bool:
    return now.holds("at_speed" if now.mode == "velocity" and now.holds("running") else "standing")


def _last(now: StatesNow) -> int:
    return int(now.kept("cia402.word"))


def words_of_control(now: StatesNow, word: int) -> tuple[list[str], dict[str, float]]:
    """Commands that a control word is, and cells that keep what it leads to."""
    before = _last(now)
    kept: dict[str, float] = {"cia402.word": word}

    def rises(bit: int) -> bool:
        return bool(word & bit and not before & bit)

    if now.holds("fault"):
        if not rises(_RESET):
            return [], kept
        return ["reset"], kept | {STATE: DISABLED}
    words, state, is_on = _switched(now, word)
    if not is_on:
        return words, kept | {STATE: state}
    return [*words, *_moved(now, word, rises)], kept | {STATE: SWITCHED_ON}


def _switched(now: StatesNow, word: int) -> tuple[list[str], int, bool]:
    """Commands of the change of the state, the state while it is off, and whether it is on then."""
    was_on, state = now.holds("enabled"), int(now.kept(STATE))
    off = ["disable"] if was_on else []
    if not word & _VOLTAGE:
        return off, DISABLED, False
    if not word & _NO_QUICK_STOP:
        return (["halt", *off] if was_on else []), DISABLED, False
    if not word & _SWITCH_ON:
        return off, READY, False
    if not was_on and state == DISABLED:
        return [], DISABLED, False
    if not word & _OPERATE:
        return off, SWITCHED_ON, False
    return ([] if was_on else ["enable"]), SWITCHED_ON, True


def _moved(now: StatesNow, word: int, rises: Callable[[int], bool]) -> list[str]:
    if word & _HALT:
        return ["stop"] if rises(_HALT) else []
    if now.mode == "velocity":
        return [] if now.holds("running") else ["run"]
    if now.mode in ("home", "search_home"):
        return [now.mode] if rises(_NEW_SET_POINT) else []
    if not rises(_NEW_SET_POINT) or not now.mode:
        return []
    return ["start_relative" if word & _RELATIVE or now.mode == "relative" else "start_absolute"]
