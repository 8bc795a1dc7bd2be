"""Packets of HerkuleX servos, and the two servos of the arm as their bus sees them."""

from device_profiles.walter.arm_parts import ServoPart
from hil.vocab.firmware import ArmJoint

BROADCAST = 0xFE
RAM_WRITE, RAM_READ, MOVE, STATUS = 3, 4, 6, 7
REPLIES = 0x40
"""Added to the command of a reply."""
TORQUE, POSITION, PWM = 0x34, 0x3A, 0x40
"""Registers."""
TORQUE_ON = 0x60
STATUS_BYTES, READ_BYTES = 9, 13
"""Lengths of replies."""
DEG_PER_COUNT, CENTRE_COUNTS, MOST_COUNTS = 0.325, 512, 1023
_HEADER = b"\xff\xff"


def packet(servo_id: int, command: int, data: bytes = b"") -> bytes:
    """Make a packet with its two checksums."""
    size = 7 + len(data)
    first = size ^ servo_id ^ command
    for byte in data:
        first ^= byte
    first &= 0xFE
    return _HEADER + bytes((size, servo_id, command, first, ~first & 0xFE)) + data


def register_write(servo_id: int, register: int, value: bytes) -> bytes:
    return packet(servo_id, RAM_WRITE, bytes((register, len(value))) + value)


def register_read(servo_id: int, register: int) -> bytes:
    return packet(servo_id, RAM_READ, bytes((register, 2)))


def move(servo_id: int, position: int, playtime: int) -> bytes:
    """Move (S_JOG) with a blue light. ``playtime``: in units of 11.2 ms."""
    return packet(servo_id, MOVE, bytes((playtime, position & 0xFF, position >> 8, 8, servo_id)))


def reply_data(received: bytes, size: int) -> bytes | None:
    """Data of a reply of so many bytes; None: there is none, or its checksums are wrong."""
    at = received.rfind(_HEADER)
    found = received[at : at + size] if at >= 0 else b""
    if len(found) < size or found != packet(found[3], found[4], found[7:]):
        return None
    return found[7:]


class ServoTwin:
    """Servo of the arm: what it answers. A move sets its position at once, with or without torque."""

    def __init__(self, part: ServoPart, joint: ArmJoint, null_deg: float) -> None:
        self._part, self._joint, self._null_deg = part, joint, null_deg
        self._torque = 0

    @property
    def position(self) -> int:
        """Position in counts, where the joint is."""
        counts = (self._joint.do("where") + self._null_deg) / DEG_PER_COUNT + CENTRE_COUNTS
        return max(0, min(MOST_COUNTS, round(counts)))

    def answer(self, sent: bytes) -> bytes:
        """Answer a packet from the bus; returns the reply, or nothing."""
        servo_id, command, data = sent[3], sent[4], sent[7:]
        if servo_id not in (self._part.servo_id, BROADCAST) or not self._joint.do("answers"):
            return b""
        if command == STATUS:
            return packet(self._part.servo_id, STATUS | REPLIES, bytes(2))
        if command == RAM_READ:
            value = self.position if data[0] == POSITION else 0
            answer = data + value.to_bytes(2, "little") + bytes(2)
            return packet(self._part.servo_id, RAM_READ | REPLIES, answer)
        if command == RAM_WRITE and data[0] == TORQUE:
            self._torque = data[2]
            self._joint.do("enable", float(self._torque == TORQUE_ON))
        elif command == MOVE:
            counts = data[1] | data[2] << 8
            self._joint.do("place", (counts - CENTRE_COUNTS) * DEG_PER_COUNT - self._null_deg)
        return b""
