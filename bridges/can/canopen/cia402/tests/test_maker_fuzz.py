"""Any frames at a maker's drive: it answers, refuses or is silent, and never raises."""

import random
from pathlib import Path
from struct import pack

import pytest
from maker_rig import NODE, MakerWorld

from bridges.can.canopen.node.data_types import size_of
from bridges.can.frames.can_frame import CanFrame

TEXT = (Path(__file__).parents[5] / "examples" / "drives" / "sd11.eds").read_text()
SEVERAL = TEXT.replace("DefaultValue=0x00000021", "DefaultValue=0x000003ED")
VALUES = (0, 1, 2, 3, 6, 7, 8, 9, 0x0F, 0x1F, 0x7F, 0x80, 0xFF, 2**31 - 1, 2**31, 2**32 - 1)
WORDS = (0x00, 0x02, 0x06, 0x07, 0x0F, 0x1F, 0x3F, 0x5F, 0x80, 0x10F)


def frame_of(chance: random.Random, world: MakerWorld) -> CanFrame:
    entries = [*world.node.dictionary.entries.values()]
    kind, entry = chance.random(), chance.choice(entries)
    if kind < 0.5:
        size = size_of(entry.data_type)
        size = size if size in (1, 2, 4) and chance.random() < 0.9 else chance.choice((1, 2, 4))
        value = chance.choice((*VALUES, chance.getrandbits(32))) & ((1 << 8 * size) - 1)
        command = 0x23 | (4 - size) << 2
        return CanFrame(0x600 + NODE, pack("<BHBI", command, entry.index, entry.subindex, value))
    if kind < 0.65:
        return CanFrame(0x600 + NODE, pack("<BHBI", 0x2B, 0x6040, 0, chance.choice(WORDS)))
    if kind < 0.75:
        return CanFrame(0x080)
    if kind < 0.85:
        return CanFrame(chance.choice((0x200, 0x300)) + NODE, chance.randbytes(chance.randrange(9)))
    if kind < 0.9:
        return CanFrame(0x000, bytes((chance.choice((1, 1, 2, 0x80, 0x81, 0x82)), 0)))
    return CanFrame(0x600 + NODE, pack("<BHBI", 0x40, entry.index, entry.subindex, 0))


@pytest.mark.parametrize("text", [TEXT, SEVERAL], ids=["as it is", "all modes"])
@pytest.mark.parametrize("seed", range(2))
def test_nothing_raises(text: str, seed: int) -> None:
    chance, world = random.Random(seed), MakerWorld(text)
    for _ in range(400):
        world.node.hear(frame_of(chance, world), world.axis.now_ns)
        world.run(chance.choice((0, 1, 1, 5, 20)))
    world.heard.clear()
    world.send_message(0x000, bytes((0x81, 0)))
    assert any(frame.id == 0x700 + NODE for frame in world.heard), "it boots"
