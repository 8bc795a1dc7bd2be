"""The end of a bench with real drives: all stop at once, before any line is left."""

import asyncio
from types import SimpleNamespace
from typing import Any

from hil.live.devices.bench_devices import Devices
from hil.live.devices.drive_device import DriveDevice


def drive(name: str, events: list[str]) -> DriveDevice:
    async def stop_motion() -> None:
        events.append(f"{name} stops")
        await asyncio.sleep(0)
        events.append(f"{name} stands")

    async def leave_line(lines: Any) -> None:
        events.append(f"{name} is left")

    axis = SimpleNamespace(end=stop_motion)
    control: Any = SimpleNamespace(drive=SimpleNamespace(name=name), axis=axis, end=leave_line)
    lines: Any = None
    return DriveDevice(control, lines, "modbus_drive", "/dev/ttyUSB0", 1.0)


def test_drives_stop_together_and_are_left_once_they_stand() -> None:
    events: list[str] = []
    devices = Devices({name: drive(name, events) for name in ("d1", "d2")})

    async def end() -> None:
        await devices.stop()
        await devices.close()

    asyncio.run(end())
    assert events == ["d1 stops", "d2 stops", "d1 stands", "d2 stands", "d2 is left", "d1 is left"]


def test_a_drive_that_a_reload_takes_away_stops_before_it_is_left() -> None:
    events: list[str] = []
    asyncio.run(drive("d1", events).close())
    assert events == ["d1 stops", "d1 stands", "d1 is left"]
