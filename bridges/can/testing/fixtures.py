"""Fixtures of a CAN bus: ``canbus`` and ``drive``, which the test kit's plugin brings with its own."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from bridges.can.testing.can_faces import CanBusFace, DriveFace
    from hil.testing.bench import Bench


@pytest.fixture
def canbus(bench: "Callable[..., Bench]") -> "Callable[..., CanBusFace]":
    """Make a bench of CANopen drives on one bus, and a node of the test's own beside them: ``canbus(4)`` has
    ``m1`` to ``m4`` with the node ids 1 to 4 on ``can0``, and ``.bench``. ``profile``: of all, ``bit_rate``:
    of the bus, ``switches``: of each, as the configuration has them."""

    def make(
        drives: int = 1,
        *,
        profile: str = "mechaduino",
        bit_rate: int = 1_000_000,
        first_id: int = 1,
        switches: Mapping[str, Any] | None = None,
        seed: int = 0,
    ) -> "CanBusFace":
        from bridges.can.testing.can_faces import canbus_config

        config = canbus_config(drives, profile, bit_rate, first_id, switches or {})
        face: CanBusFace = bench(config, seed).can()
        return face

    return make


@pytest.fixture
def drive(canbus: "Callable[..., CanBusFace]") -> "Callable[..., DriveFace]":
    """Make a CANopen drive on a bus with a node of the test's own, as ``canbus``, past its board's start:
    ``drive()``, ``drive(profile="sac")``. Its axis is ``.canbus.bench.axis(drive.axis)``."""

    def make(**of: Any) -> "DriveFace":
        made = canbus(1, **of).drives()[0]
        made.await_ready()
        return made

    return make
