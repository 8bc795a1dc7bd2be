"""State of a drive by the values of its objects, and its emergencies in words."""

from collections.abc import Mapping
from dataclasses import dataclass

from bridges.can.canopen.canopen_codes import emergency_words
from bridges.can.canopen.cia402_words import PROFILE_POSITION, TARGET_REACHED, DriveState, has_fault, state_of
from bridges.can.canopen.master.drive_units import DriveUnits
from hil.drives.drive_link import Reading
from hil.vocab.axis import TURNS_RPM


def reading_of(raw: Mapping[str, int], units: DriveUnits, at_ns: int) -> Reading:
    """Reading of the values of a drive's objects, by the fields of ``process_data``."""
    statusword, mode = raw["statusword"], raw.get("mode", 0)
    values: dict[str, float] = {
        "position_deg": raw["position"] / units.position_per_deg,
        "statusword": statusword,
        "mode": mode,
    }
    if "velocity" in raw:
        values["velocity_rpm"] = raw["velocity"] / units.velocity_per_rpm
    if "current" in raw and units.current_A is not None:
        values["current_A"] = raw["current"] * units.current_A
    if "error" in raw:
        values["fault_code"] = raw["error"]
    bits = {
        "status.enabled": state_of(statusword) is DriveState.OPERATION_ENABLED,
        "status.fault": has_fault(statusword),
        "status.moving": _moves(statusword, mode, values.get("velocity_rpm")),
    }
    return Reading(at_ns, values, bits)


def _moves(statusword: int, mode: int, velocity_rpm: float | None) -> bool:
    """True while the drive moves. Only the modes with targets say that one was reached; and some say so of
    the first target alone, not of the time before it."""
    turns = abs(velocity_rpm) > TURNS_RPM if velocity_rpm is not None else None
    is_on_its_way = mode == PROFILE_POSITION and not statusword & TARGET_REACHED
    return is_on_its_way if turns is None else turns


def fault_text(reading: Reading, emergency: str | None) -> str | None:
    """Say a drive's fault, with its error code or else its last emergency; None: it has none."""
    if not reading.bits["status.fault"]:
        return None
    if code := int(reading.values.get("fault_code", 0)):
        return f"the drive has fault {code:04X}h ({emergency_words(code)})"
    return f"the drive has a fault, emergency {emergency}" if emergency else "the drive has a fault"


def emergency_text(data: bytes) -> str | None:
    """Say an emergency message; empty: the errors are over; None: it is no such message. CiA 301, 7.2.7."""
    if len(data) != 8:
        return None
    code = int.from_bytes(data[:2], "little")
    if not code:
        return ""
    own = f", maker's bytes {data[3:].hex(' ')}" if any(data[3:]) else ""
    return f"{code:04X}h ({emergency_words(code)}){own}"


@dataclass
class EmergencyLog:
    """Emergency messages of a drive. ``text``: the last, in words, until it says that it is over."""

    count: int = 0
    text: str | None = None

    def hear(self, data: bytes) -> str | None:
        """Take a message; answers what to log: something is new."""
        if (text := emergency_text(data)) is None:
            return None
        self.count += 1
        is_new, self.text = (text or None) != self.text, text or None
        return (f"emergency {text}" if text else "its emergency is over") if is_new else None
