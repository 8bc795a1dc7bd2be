"""Node of a maker's file over an axis that does what it is told, and a master: the ``canopen`` library with
the same file."""

import io
import subprocess
from pathlib import Path
from typing import Any

import canopen
from canopen.objectdictionary import ODVariable, datatypes
from canopen.objectdictionary.eds import import_eds
from canopen.profiles.p402 import BaseNode402
from drive_rig import SimpleAxis
from test_drive_eds import GONE, TOOLS

from bridges.can.canopen.cia402.maker_drive import MakerDrive, MakerLines, identity_of
from bridges.can.canopen.master.drive_units import GivenUnits
from bridges.can.canopen.node.canopen_node import CanOpenNode
from bridges.can.canopen.node.eds import eds_text
from bridges.can.canopen.node.eds_reader import read_device
from bridges.can.frames.can_frame import CanFrame
from hil.vocab.time import NS_PER_MS

NODE = 5
_TOLD = range(0x1000, 0x1004)
_BYTES = {**dict.fromkeys((1, 2, 5), 1), **dict.fromkeys((3, 6), 2), **dict.fromkeys((4, 7, 8), 4)}


class MakerWorld(canopen.Network):  # type: ignore[misc]
    """Network with a maker's drive, in whose time each frame of the master takes a millisecond."""

    def __init__(self, text: str, lines: MakerLines | None = None, axis: SimpleAxis | None = None) -> None:
        super().__init__()
        self.axis = axis or SimpleAxis()
        self.text, self.lines = text, lines or MakerLines(GivenUnits(1000.0))
        self.heard: list[CanFrame] = []
        device = read_device(text, "maker.eds")
        identity = self.identity = identity_of(device, self.lines, 77)
        self.node = CanOpenNode(
            NODE,
            500_000,
            lambda services: MakerDrive(self.axis, services, device, self.lines, identity),
            identity,
            self._hear,
        )
        self.node.power_up(0)
        self.run(20)

    def exported(self) -> str:
        """The node's own data sheet, as ``hil can eds`` prints it."""
        return eds_text(self.node.dictionary, self.identity, "maker.eds")

    def master(self, text: str = "") -> BaseNode402:
        """The library's drive of profile 402, by the same file or by another text."""
        node = BaseNode402(NODE, import_eds(io.StringIO(text or self.text), NODE))
        self.add_node(node)
        node.sdo.RESPONSE_TIMEOUT = 0.001
        return node

    def send_message(self, can_id: int, data: Any, remote: bool = False) -> None:
        self.node.hear(CanFrame(can_id, b"" if remote else bytes(data), False, remote), self.axis.now_ns)
        self.run(1)

    def run(self, ms: float) -> None:
        until_ns = self.axis.now_ns + round(ms * NS_PER_MS)
        while self.node.due_ns <= until_ns:
            self.axis.now_ns = max(self.axis.now_ns, self.node.due_ns)
            self.node.step(self.axis.now_ns)
        self.axis.now_ns = until_ns

    def _hear(self, frame: CanFrame) -> None:
        self.heard.append(frame)
        self.notify(frame.id, bytearray(frame.data), self.axis.now_ns / 1e9)


def variables_of(master: BaseNode402) -> list[ODVariable]:
    """All entries of a file, as the library has them."""
    found: list[ODVariable] = []
    for thing in master.object_dictionary.values():
        found += [thing] if isinstance(thing, ODVariable) else list(thing.values())
    return [each for each in found if each.index >= 0x1000]  # below are the dummies of mappings


def differences(world: MakerWorld, master: BaseNode402) -> list[str]:
    """Differences between what reading each object shows and the file."""
    wrong: list[str] = []
    live = {key for key, entry in world.node.dictionary.entries.items() if entry.is_live}
    for each in variables_of(master):
        where = f"{each.index:04X}h:{each.subindex} {each.name}"
        try:
            data = master.sdo.upload(each.index, each.subindex)
        except canopen.SdoAbortedError as error:
            if not (each.access_type == "wo" and error.code == 0x0601_0001) and error.code != 0x0800_0024:
                wrong.append(f"{where}: {error}")
            continue
        if each.access_type == "wo":
            wrong.append(f"{where}: it can be read")
        size = _BYTES.get(each.data_type)
        if size and len(data) != size:
            wrong.append(f"{where}: {len(data)} bytes")
        is_own = (each.index << 8 | each.subindex) in live or each.index in (0x1018, *_TOLD)
        key = each.index, each.subindex
        told = each.default if each.value is None else each.value
        if told is None or is_own or key in world.lines.values or not size:
            continue
        value = each.decode_raw(data)
        if each.data_type in datatypes.INTEGER_TYPES and (value - told) % (1 << 8 * size):
            wrong.append(f"{where}: {value}, not {told}")
    return wrong


def refusals(world: MakerWorld, master: BaseNode402) -> list[str]:
    """Differences in refusals: of objects that are read-only, and of numbers beyond limits."""
    wrong: list[str] = []
    for each in variables_of(master):
        where = f"{each.index:04X}h:{each.subindex} {each.name}"
        size = _BYTES.get(each.data_type)
        tries: list[tuple[int, int]] = []
        if each.access_type in ("ro", "const"):
            tries.append((0, 0x0601_0002))
        elif each.data_type in datatypes.INTEGER_TYPES and size:
            signed = each.data_type in datatypes.SIGNED_TYPES
            most = (1 << 8 * size - signed) - 1
            if each.max is not None and each.max < most:
                tries.append((each.max + 1, 0x0609_0031))
            if each.min is not None and each.min > -(most + 1) * signed:
                tries.append((each.min - 1, 0x0609_0032))
        for value, code in tries:
            data = (value % (1 << 8 * (size or 1))).to_bytes(size or 1, "little")
            try:
                master.sdo.download(each.index, each.subindex, data)
                wrong.append(f"{where}: {value} was taken")
            except canopen.SdoAbortedError as error:
                if error.code != code:
                    wrong.append(f"{where}: {error} in place of {code:#010x}")
    return wrong


def said_by_dcfchk(text: str, folder: Path) -> str:
    """Output of Lely's ``dcfchk`` for a data sheet; empty: no complaint."""
    (folder / "pkg_resources.py").write_text(GONE)
    (folder / "maker.eds").write_text(text)
    done = subprocess.run(
        [TOOLS / "dcfchk", "-n", str(NODE), "maker.eds"],
        cwd=folder,
        env={"PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    return done.stdout + done.stderr


def enable(world: MakerWorld, master: BaseNode402, mode: int) -> None:
    """Lead the drive into a mode with its power on."""
    master.nmt.state = "OPERATIONAL"
    master.sdo[0x6060].raw = mode
    for word in (0x06, 0x07, 0x0F):
        master.sdo[0x6040].raw = word
        world.run(20)
    assert master.sdo[0x6041].raw & 0x6F == 0x27, hex(master.sdo[0x6041].raw)


def move_to(world: MakerWorld, master: BaseNode402, target: int) -> int:
    """Make a profile move, and answer the position in the end."""
    for index, value in ((0x6081, 4000), (0x6083, 40_000), (0x6084, 40_000)):
        if index in master.object_dictionary:
            master.sdo[index].raw = value
    master.sdo[0x607A].raw = target
    master.sdo[0x6040].raw = 0x0F
    master.sdo[0x6040].raw = 0x1F
    world.run(5000)
    assert master.sdo[0x6041].raw & 0x400, "the target is reached"
    position: int = master.sdo[0x6064].raw
    return position
