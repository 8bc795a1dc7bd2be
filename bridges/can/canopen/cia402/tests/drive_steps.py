"""Steps of a dialogue with a drive: what a master writes and waits for, and what it reads then."""

from dataclasses import dataclass

from drive_rig import DriveRig


@dataclass(frozen=True)
class Write:
    index: int
    value: int
    subindex: int = 0


@dataclass(frozen=True)
class Wait:
    ms: float


@dataclass(frozen=True)
class Sync:
    """SYNC, and the time to the next."""

    ms: float = 1


@dataclass(frozen=True)
class Status:
    mask: int
    bits: int


@dataclass(frozen=True)
class Read:
    index: int
    value: int
    off: int = 0


@dataclass(frozen=True)
class Emcy:
    codes: tuple[int, ...]


Step = Write | Wait | Sync | Status | Read | Emcy


def word(value: int) -> Write:
    return Write(0x6040, value)


def to(position: int, *how: int) -> list[Step]:
    return [Write(0x607A, position), *map(word, how)]


def play(rig: DriveRig, steps: list[Step]) -> None:
    for place, step in enumerate(steps):
        where = f"step {place}: {step}, at {rig.now_ns / 1e6} ms"
        match step:
            case Write(index, value, subindex):
                rig.write(index, value, subindex)
            case Wait(ms):
                rig.run(ms)
            case Sync(ms):
                rig.sync()
                rig.run(ms)
            case Status(mask, bits):
                assert rig.status & mask == bits, f"{where}: {rig.status:#06x}"
            case Read(index, value, off):
                assert abs(rig.read(index) - value) <= off, f"{where}: {rig.read(index)}"
            case Emcy(codes):
                assert tuple(rig.emergencies) == codes, where
