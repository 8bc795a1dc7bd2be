"""The service in a virtual machine with Debian's real-time kernel: limits, vcan, and power that goes.

Power cuts: the board's memory is on a disk of its own, ``VolatileDisk``, whose write cache is lost at the
cut but for what chance has written of it. A cut is an image of the medium at one request, taken while the
guest runs on; ``e2fsck`` plays the image's journal back as the kernel does at a mount, ``debugfs`` takes the
file out. So one boot gives hundreds of cuts. At the end the machine is really killed, and the guest
itself finds what there is.
"""

import os
import random
import re
import shlex
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from container import until
from debian import HIL_PYTHON, CannotError, need, run, tree_with_hil, tree_with_kernel
from e2e_support import Place, config
from guest import REAL_TIME, Guest, root_image
from volatile_disk import VolatileDisk

from device_profiles.sac.eeprom import Eeprom
from hil.firmware.nvm import decode

CUTS = int(os.environ.get("HIL_POWER_CUTS", "60"))
SEED = int(os.environ.get("HIL_SEED", "1"))
DISK_SIZE = "16M"
REQUESTS = 12  # a save takes about nine: a cut is at any of them
PATIENCE_S = 120.0
SITE = """\
bench: site
devices:
  r1: {profile: sac, at: /dev/ttyUSB0}
  s1: {profile: sac, port: {kind: tcp, listen: 0.0.0.0:7001}}
"""
BUS = """\
bench: bus
devices:
  m1: {profile: mechaduino, flash: {table: identity}}
can:
  can0: {bit_rate: 500000, nodes: {m1: 5}, taps: {slcan0: {port: pty}}}
bridges:
  can: {channels: {can0: {interface: socketcan, channel: vcan0}}}
"""
READ_IDENTITY = "605#4018100100000000"
SITE_ADDRESS = "10.9.8.7"
LAB = "bench: lab\ndevices:\n  m1: {profile: mechaduino, flash: {table: identity}}\n  s1: {profile: sac}\n"
START = (
    "mount -t ext4 /dev/vdb /var/lib/private && chmod 700 /var/lib/private && "
    "mkdir -p /etc/systemd/system/hil@.service.d && "
    "ln -sf /usr/local/share/hil/systemd/realtime.conf /etc/systemd/system/hil@.service.d/ && "
    # An emulated CPU is slower than what the watchdog and clients are made for.
    "printf '[Service]\\nWatchdogSec=60\\nTimeoutStartSec=300\\n' "
    "> /etc/systemd/system/hil@.service.d/slow.conf && "
    "systemctl daemon-reload && systemctl start hil@lab || "
    "{ journalctl -u hil@lab -o cat --no-pager; false; }"
)
FRAME = (
    "import socket; "
    "a, b = (socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW) for _ in range(2)); "
    "[each.bind(('vcan0',)) for each in (a, b)]; b.settimeout(20); "
    "a.send(bytes.fromhex('2301000002000000cafe000000000000')); print(b.recv(16).hex())"
)


class Setup:
    """The root file system, the disk, and the guest that runs now."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.kernel_tree = tree_with_kernel()
        tree = tree_with_hil(folder, self.kernel_tree)
        (tree / "etc/hil").mkdir(exist_ok=True)
        (tree / "etc/hil/lab.yaml").write_text(LAB)
        (tree / "etc/hil/site.yaml").write_text(SITE)
        (tree / "etc/hil/bus.yaml").write_text(BUS)
        self.root = root_image(tree, folder / "root.img")
        blank = folder / "blank.img"
        run("mke2fs", "-q", "-t", "ext4", blank, DISK_SIZE)
        self.place = Place().__enter__()
        board = self.place.serve(
            config(speed=1, devices={"s1": {"profile": "sac", "port": "tcp", "flash": {}}})
        )
        host, _, port = board.status("s1")["address"].removeprefix("socket://").rpartition(":")
        self.board = host, int(port)
        self.disk = VolatileDisk(blank.read_bytes(), folder / "disk.sock", random.Random(SEED))

    def boot(self) -> None:
        host, port = self.board
        self.guest = Guest(
            *(self.kernel_tree, self.root, REAL_TIME),
            *("-drive", f"file=nbd:unix:{self.disk.path},format=raw,if=virtio,cache=writeback"),
            # The guest's kernel takes it for an adapter of FTDI's.
            *("-chardev", f"socket,id=board,host={host},port={port}"),
            *("-device", "piix3-usb-uhci", "-device", "usb-serial,chardev=board"),
        )
        self.guest.run(START, timeout_s=300)

    def close(self) -> None:
        if hasattr(self, "guest"):
            self.guest.kill()
        self.disk.close()
        self.place.__exit__(None, None, None)


@pytest.fixture(scope="module")
def setup() -> Iterator[Setup]:
    try:
        need({"qemu-system-x86_64": "qemu-system-x86", "mke2fs": "e2fsprogs", "debugfs": "e2fsprogs"})
        with tempfile.TemporaryDirectory(prefix="hil-qemu-") as folder:
            made = Setup(Path(folder))
            try:
                made.boot()
                yield made
            finally:
                made.close()
    except CannotError as error:
        pytest.skip(str(error))


def test_the_kernel_is_a_real_time_kernel(setup: Setup) -> None:
    assert "PREEMPT_RT" in setup.guest.run("uname -v")


def test_real_time_priority_and_locked_memory_are_granted(setup: Setup) -> None:
    said = setup.guest.run(
        "hil status --json | python3 -c 'import json, sys; print(json.load(sys.stdin)[\"rt_line\"])'"
    )
    assert "rt: ok (SCHED_FIFO 80" in said, said
    limits = setup.guest.run("cat /proc/$(systemctl show --value -p MainPID hil@lab)/limits")
    words = {
        " ".join(line.split()[: -2 if "bytes" in line or " us" in line else -1])
        for line in limits.splitlines()
    }
    assert any(each.startswith("Max realtime priority 80") for each in words), limits
    assert f"Max locked memory {45 << 20}" in words, limits  # LimitMEMLOCK=45M of the unit


def test_locked_memory_is_what_is_promised(setup: Setup) -> None:
    status = setup.guest.run("grep VmLck /proc/$(systemctl show --value -p MainPID hil@lab)/status")
    locked_kB = int(status.split()[1])
    slots = 2 * 2  # two for each device
    assert 1024 < locked_kB <= 16 * 1024 + 64 * slots, status


def test_the_core_thread_has_no_page_faults(setup: Setup) -> None:
    """Expect none after the warm-up, for half a minute of boards at work."""
    faults = (
        "for t in /proc/$(systemctl show --value -p MainPID hil@lab)/task/*; do "
        "set -- $(cut -d')' -f2- < $t/stat); [ ${39} = 1 ] && echo $8 ${10}; done"
    )
    before = setup.guest.run(faults)
    setup.guest.run("sleep 30")
    assert before == setup.guest.run(faults)
    assert len(before.splitlines()) == 1, before  # the one thread whose policy is SCHED_FIFO


def test_vcan_is_there(setup: Setup) -> None:
    setup.guest.run("modprobe vcan && ip link add vcan0 type vcan && ip link set vcan0 up")
    assert "2301000002000000cafe" in setup.guest.run(f"python3 -c {shlex.quote(FRAME)}")


@pytest.fixture
def bus(setup: Setup) -> Iterator[Guest]:
    """A bench with a bus in the guest: a channel at vcan0, and an slcan adapter at a pty."""
    folder = "/etc/systemd/system/hil@bus.service.d"
    guest = setup.guest
    guest.run("modprobe vcan; ip link add vcan0 type vcan; ip link set vcan0 up")
    guest.run(
        f"mkdir -p {folder} && ln -sf /usr/local/share/hil/systemd/can.conf {folder} && "
        "systemctl daemon-reload && systemctl start hil@bus || "
        "{ journalctl -u hil@bus -o cat --no-pager; false; }",
        timeout_s=300,
    )
    try:
        yield guest
    finally:
        guest.run("systemctl stop hil@bus", check=False)


def dumped(guest: Guest, interface: str, send: str) -> str:
    """What candump hears until a node has answered, while cansend asks it again and again."""
    ask = f"for i in $(seq 30); do cansend {interface} {send}; sleep 1; done"
    dump = f"candump -L -n 1 -T 30000 {interface},585:7FF"
    return guest.run(f"({ask}) & {dump}; kill $!; wait", check=False)


def test_can_utils_and_a_node_talk_through_vcan(bus: Guest) -> None:
    assert "vcan0 585#43181001" in dumped(bus, "vcan0", READ_IDENTITY)
    said = bus.run(
        "hil capture --bench bus can0 -w /tmp/c.log & "  # slow to start on an emulated CPU
        "for i in $(seq 60); do for frame in 000#8105 1ABCDEF0#0102030405060708 123#R; do "
        "cansend vcan0 $frame; done; sleep 1; grep -q 705#00 /tmp/c.log && break; done; "
        "kill $!; wait; cat /tmp/c.log",
        check=False,
    )
    for frame in ("can0 000#8105", "can0 1ABCDEF0#0102030405060708", "can0 123#R", "can0 705#00"):
        assert frame in said
    assert "vcan0@500000" in bus.run("timeout 3 canbusload vcan0@500000", check=False)
    status = bus.run("hil status --bench bus --json")
    assert '"can0.socketcan"' in status


def test_logs_of_hil_are_played_by_canplayer(bus: Guest) -> None:
    log = "(1700000000.000000) can0 605#4018100100000000"
    said = bus.run(
        f"echo '{log}' > /tmp/p.log; (sleep 2; canplayer -I /tmp/p.log vcan0=can0) & "
        "candump -L -n 1 -T 30000 vcan0,585:7FF",
        check=False,
    )
    assert "585#43181001" in said


def test_slcand_makes_an_interface_of_the_tap(bus: Guest) -> None:
    if "exit 0" not in bus.run("modprobe slcan; echo exit $?", check=False):
        pytest.skip("this kernel has no slcan")
    tty = "$(readlink -f /run/hil/bus/can0.slcan0)"
    bus.run(f"slcand -o -s6 {tty} hilcan0; sleep 2; ip link set hilcan0 up")
    assert "585#43181001" in dumped(bus, "hilcan0", READ_IDENTITY)
    bus.run("pkill slcand", check=False)


def test_an_interface_that_is_not_there_is_told(bus: Guest) -> None:
    bus.run("sed s/vcan0/vcan7/ /etc/hil/bus.yaml > /tmp/none.yaml")
    said = bus.run("hil check /tmp/none.yaml", check=False)
    assert "there is no interface 'vcan7'" in said
    assert "ip link add vcan7 type vcan" in said


class Site:
    """A second bench in the guest, with a real adapter and a listener beyond loopback."""

    FOLDER = "/etc/systemd/system/hil@site.service.d"

    def __init__(self, guest: Guest) -> None:
        self.guest = guest

    def restart(self, *drop_ins: str) -> None:
        links = "".join(
            f"ln -s /usr/local/share/hil/systemd/{name}.conf {self.FOLDER}; " for name in drop_ins
        )
        self.guest.run(
            f"systemctl stop hil@site; rm -rf {self.FOLDER}; mkdir {self.FOLDER}; {links}"
            "systemctl daemon-reload && systemctl start hil@site",
            timeout_s=300,
        )

    def reached(self, url: str) -> bool:
        """True if a SAC answers there within a minute."""
        ask = (
            "import serial, sys, time; end = time.monotonic() + 60; heard = b''\n"
            f"p = serial.serial_for_url({url!r}, 38400, timeout=1)\n"
            "while b'SAC>' not in heard and time.monotonic() < end:\n"
            "    p.write(b'\\r'); heard += p.read(64)\n"
            "sys.exit(b'SAC>' not in heard)"
        )
        one_line = shlex.quote(f"exec({ask!r})")
        said = self.guest.run(f"{HIL_PYTHON} -c {one_line} 2>&1; echo exit $?")
        return "exit 0" in said.splitlines()


@pytest.fixture
def site(setup: Setup) -> Iterator[Site]:
    guest = setup.guest
    guest.run(
        f"ip link add dummy0 type dummy && ip addr add {SITE_ADDRESS}/24 dev dummy0 && ip link set dummy0 up"
    )
    try:
        yield Site(guest)
    finally:
        guest.run("systemctl stop hil@site; ip link del dummy0")


def test_drop_ins_open_adapters_and_the_network_and_nothing_else_does(setup: Setup, site: Site) -> None:
    assert "dialout" in setup.guest.run("stat -c %G /dev/ttyUSB0")
    adapter, listener = "/run/hil/site/r1", f"socket://{SITE_ADDRESS}:7001"
    site.restart()
    assert "adapters.conf" in setup.guest.run("hil status --bench site")
    assert not site.reached(listener)
    site.restart("network")
    assert site.reached(listener)
    assert not site.reached(adapter)
    site.restart("adapters")
    assert site.reached(adapter)
    assert not site.reached(listener)


class Lost(AssertionError):
    """Loss of a save that was acknowledged: it is not on the medium."""


def stored(image: bytes, folder: Path) -> tuple[int, int] | None:
    """Commits and acceleration in the file of s1, after the journal was played back; None: no file."""
    path, out = folder / "cut.img", folder / "s1.nvm"
    path.write_bytes(image)
    out.unlink(missing_ok=True)
    checked = subprocess.run(["e2fsck", "-p", "-f", path], capture_output=True, text=True, timeout=60)
    assert checked.returncode <= 1, checked.stdout + checked.stderr  # 1: put right, as a mount does
    run("debugfs", "-R", f"dump /hil/lab/s1.nvm {out}", path)
    if not out.exists() or not out.stat().st_size:
        return None
    content = decode(out.read_bytes()).content
    return content.counter, Eeprom.unpacked(content.sections["eeprom"]).parameters.acc


def judge(image: bytes, folder: Path, base: int, acked: int) -> int:
    """Saves that the medium has beyond those acknowledged.

    Raises:
        Lost: fewer.
    """
    found = stored(image, folder)
    if found is None:
        raise Lost(f"no file, after {acked} acknowledged saves")
    number = found[0] - base
    if number < acked:
        raise Lost(f"save {number}, after {acked} acknowledged")
    assert found[1] == 100 + number % 900, found
    return number - acked


def test_power_cuts_lose_nothing_that_was_acknowledged(setup: Setup) -> None:
    chance, guest, ahead = random.Random(SEED), setup.guest, [0, 0, 0]
    guest.begin(f"{HIL_PYTHON} /usr/local/lib/eeprom_writer.py 1 100000000")
    until(lambda: guest.acked >= 1, "the first save", PATIENCE_S)
    assert guest.base is not None
    first, first_acked = b"", 0
    for _ in range(CUTS):
        image, acked = setup.disk.cut(chance.randint(1, REQUESTS), PATIENCE_S, lambda: guest.acked)
        if not first:
            first, first_acked = image, acked
        beyond = judge(image, setup.folder, guest.base, acked)
        ahead[min(beyond, 2)] += 1
    print(f"{CUTS} cuts in {guest.acked} saves, {setup.disk.requests} requests; ahead by 0, 1, more: {ahead}")
    assert guest.acked > first_acked
    with pytest.raises(Lost):  # the check sees a loss: an early image, judged by what was answered late
        judge(first, setup.folder, guest.base, guest.acked)


@pytest.mark.parametrize("attempt", range(1 if CUTS < 300 else 3))
def test_after_the_machine_was_killed_it_starts_with_what_was_acknowledged(
    setup: Setup, attempt: int
) -> None:
    if not setup.guest.acked:
        first = 1 + 1000 * attempt
        setup.guest.begin(f"{HIL_PYTHON} /usr/local/lib/eeprom_writer.py {first} 100000000")
        until(lambda: setup.guest.acked > first + 5, "saves", PATIENCE_S)
    setup.guest.kill()
    acked = setup.guest.acked
    setup.disk.power_cut()
    setup.boot()
    said = setup.guest.run(
        "journalctl -u hil@lab -o cat --no-pager; dmesg | grep vdb; ls /var/lib/private/hil/lab"
    )
    print(said[-300:])
    assert "damaged" not in said
    show = (
        "import serial; p = serial.Serial('/run/hil/lab/s1', 38400, timeout=10); p.write(b'$C\\r'); "
        # An open screen would take what comes next for an edit.
        "print(p.read(4096).decode()); p.write(b'x\\r'); p.read_until(b'SAC>')"
    )
    setup.guest.run("sleep 5")
    screen = setup.guest.run(f"{HIL_PYTHON} -c {shlex.quote(show)}")
    shown = re.search(r"d acc\t\t(\d\.\d\d)", screen)
    assert shown, screen
    beyond = (round(float(shown[1]) * 100) - 100 - acked) % 900
    print(f"{acked} saves acknowledged, {beyond} more found")
    assert beyond <= 1
