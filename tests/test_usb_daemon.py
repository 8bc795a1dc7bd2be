"""A bench of boards on the USB, at a kernel in Python: what their programs see, and that a log repeats it."""

import asyncio
import json
from collections.abc import Callable
from pathlib import Path

import pytest
from fake_vhci import FakeAttachment, FakeKernel

import virtual_ports.usb.port
from hil.compose.find import find_catalogue
from hil.compose.replay import replay
from hil.config import ConfigError, parse
from hil.daemon import Daemon, Serving
from hil.vocab.ports import Port, PortContext
from virtual_ports.usb import usb_port, usb_session
from virtual_ports.usb.usb_options import Options

CONFIG = """\
bench: t
speed: 20
devices:
  m1: {profile: mechaduino, port: usb}
  m2: {profile: mechaduino, port: usb, baud: 38400}
  s1: {profile: sac, port: {kind: usb, serial_number: A1}, network: usb}
"""


async def until(condition: Callable[[], object], what: str) -> None:
    for _ in range(3000):
        if condition():
            return
        await asyncio.sleep(0.01)
    raise AssertionError(f"waited for {what}")


def test_no_two_devices_have_one_serial_number() -> None:
    port = "port: {kind: usb, serial_number: A}"
    text = (
        f"bench: t\ndevices: {{m1: {{profile: mechaduino, {port}}}, m2: {{profile: mechaduino, {port}}}}}\n"
    )
    with pytest.raises(ConfigError, match='device m1 has its port in the same place, "serial number A"'):
        parse(text, "t.yaml", find_catalogue())


class Board:
    """Board as a program at its newest tty sees it."""

    def __init__(self, kernel: FakeKernel, serving: Serving, label: str) -> None:
        self.kernel, self.serving, self.label = kernel, serving, label

    @property
    def plugged(self) -> FakeAttachment:
        address = self.serving.live.places[self.label].port.address
        return next(each for each in reversed(self.kernel.plugged) if each.tty() == address)

    def opens(self, baud: int = 115200, *more: int) -> None:
        self.plugged.host.states.clear()
        self.plugged.host.open()
        self.plugged.host.set_coding(baud, *more)
        self.plugged.step()

    def closes(self) -> None:
        self.plugged.host.close()
        self.plugged.step()

    async def types(self, text: bytes, answer: bytes) -> None:
        """Type something until the board answers."""
        host = self.plugged.host
        for _ in range(300):
            host.write(text)
            self.plugged.step()
            await asyncio.sleep(0.05)
            if answer in host.received:
                return
        raise AssertionError(f"{self.label}: {answer!r} did not come, but {bytes(host.received)!r}")

    async def _second(self) -> None:
        sim = self.serving.live.sim
        end_ns = sim.now_ns + 1_000_000_000
        await until(lambda: sim.now_ns > end_ns, "a second")

    async def says_nothing(self, text: bytes) -> None:
        """Type something to which the board says nothing; what it was saying before is over first."""
        for data in (b"", text):
            self.plugged.host.received.clear()
            self.plugged.host.write(data)
            self.plugged.step()
            await self._second()
        assert self.plugged.host.received == b""


def test_boards_on_the_usb_answer_and_a_log_repeats_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(usb_session, "TOUCH_S", 0.01)
    monkeypatch.setattr(usb_port, "RESET_S", 0.05)
    log = tmp_path / "log.jsonl"

    async def use(kernel: FakeKernel, serving: Serving) -> None:
        m1, m2, s1 = (Board(kernel, serving, label) for label in ("m1", "m2", "s1"))
        texts = {each.host.descriptors[3, 3][2:].decode("utf-16-le"): each for each in kernel.plugged}
        assert list(texts) == ["t.m1", "t.m2", "A1", "t.s1.network"]
        ids = [each.host.descriptors[1, 0][8:12].hex() for each in texts.values()]
        assert ids == ["41234d80", *["2505a7a4"] * 3]  # a UART has an adapter in front of it

        m1.opens()
        await m1.types(b"m", b"Main menu")
        m2.opens(38400)
        await m2.types(b"m", b"Main menu")
        m2.closes()
        m2.opens(9600)
        await m2.says_nothing(b"m")
        m2.closes()
        m2.opens(38400, 0, 2, 7)  # 7E1: the board reads m, which has five ones, as EDh, and r as r
        await m2.says_nothing(b"m")
        assert m2.plugged.host.states == [3]
        await m2.types(b"r", b"setpoint")
        assert m2.plugged.host.states[-1] & 0x20  # a letter with an odd number of ones
        s1.opens(38400)
        await s1.types(b"\r", b">")

        first = m1.plugged
        m1.opens(1200)
        await until(lambda: serving.live.places["m1"].port.client_baud() == 1200, "1200 baud")
        m1.closes()
        await until(lambda: first.is_detached, "the reset")
        await until(lambda: serving.live.places["m1"].port.stats().away is None, "the board to come back")
        assert m1.plugged is not first
        m1.opens()
        await m1.types(b"m", b"Main menu")

    async def main() -> None:
        kernel = FakeKernel()

        def make(options: Options, context: PortContext) -> Port:
            return usb_port.UsbPort(options, context, kernel.attach)

        monkeypatch.setattr(virtual_ports.usb.port, "make", make)
        config = parse(CONFIG, "t.yaml", find_catalogue())
        state = tmp_path / "state"
        daemon = Daemon(
            config, config_folder=tmp_path, runtime_base=tmp_path, state_base=state, input_log=log
        )
        started: asyncio.Future[Serving] = asyncio.get_running_loop().create_future()
        running = asyncio.create_task(daemon.run(started.set_result))
        await asyncio.wait({running, started}, return_when=asyncio.FIRST_COMPLETED, timeout=60)
        try:
            assert started.done()
            await use(kernel, started.result())
        finally:
            daemon.stop()
            await running
        assert all(each.is_detached for each in kernel.plugged)

    asyncio.run(main())
    lines = [json.loads(line) for line in log.read_text().splitlines()[1:]]
    resets = [line for line in lines if line.get("input") == "reset"]
    assert [line["device"] for line in resets] == ["m1"]
    assert any(line.get("client_format") == "7E1" for line in lines)
    assert replay(log).difference() is None
