"""The benches of ``docs/how-to/real-can-drives.md``, as they stand there."""

import os

import pytest
from e2e_support import Place, free_port, until
from markdown_blocks import blocks

from hil.compose import find_catalogue
from hil.config import parse

NAME = "docs/how-to/real-can-drives.md"


def benches(heading: str) -> list[str]:
    return [each.text for each in blocks(NAME) if each.language == "yaml" and each.heading == heading]


def test_the_first_bench_can_be() -> None:
    (text,) = benches("Use real CANopen drives as axes")
    config = parse(text, "shop.yaml", find_catalogue())
    assert (list(config.real), list(config.twins)) == (["x", "y", "z"], ["w"])
    (units,) = benches("Units")
    given = parse(f"bench: t\ndevices:\n{units}", "units.yaml", find_catalogue()).devices["x"].units
    assert given is not None
    assert given.position_per_turn == 36000


@pytest.mark.thorough
def test_twins_of_another_daemon_are_real_drives_to_this_one(place: Place) -> None:
    port = free_port()
    group = f"239.74.{os.getpid() % 250}.{port % 250}"  # nobody else's
    far, near = benches("Try it without a drive")
    there = place.serve(
        far.replace("udp_multicast}", f"udp_multicast, channel: {group}, port: {port}}}"), bench="far"
    )
    # A line with a delay has more time for each answer: the computer of all tests is busy.
    near = near.replace("239.74.163.2", f"{group}:{port}")
    here = place.serve(near.replace('"}', '", line_delay_ms: 800}'), bench="near")
    for name in ("x", "y"):
        until(lambda name=name: here.status(name)["drive"]["state"] == "there", name)
        here.ask("do", device=name, name="enable", parameters={})
        here.ask("do", device=name, name="move_abs", parameters={"position_deg": 30.0})
    until(lambda: abs(there.status("d8")["snapshot"]["yw"] - 30) < 0.5, "30 deg")
    until(lambda: here.status("y")["snapshot"]["position_deg"] == pytest.approx(30, abs=2), "30 deg")
