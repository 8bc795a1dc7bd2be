"""Dialogues with a node, bytes and times, from ``canopen_dialogues.yaml``."""

from pathlib import Path

import pytest
import yaml
from canopen_rig import Rig, frame_of

DIALOGUES = yaml.safe_load((Path(__file__).parent / "canopen_dialogues.yaml").read_text())


@pytest.mark.parametrize("name", DIALOGUES)
def test_dialogue(name: str) -> None:
    rig = Rig()
    expected = []
    for line in DIALOGUES[name].splitlines():
        at_ms, way, *frame = line.partition(" --")[0].split()
        if way == "<":
            expected.append(f"{at_ms} {frame[0]}")
            continue
        rig.advance(float(at_ms))
        if way == ">":
            rig.node.hear(frame_of(frame[0]), rig.now_ns)
    assert [f"{each.at_ms:g} {each.frame}" for each in rig.sent] == expected
