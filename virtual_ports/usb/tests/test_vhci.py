"""Plugging in, with a folder in place of sysfs. The texts are those of the kernels named."""

import os
import socket
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

import pytest

from virtual_ports.usb.vhci import FULL_SPEED, SUPER_SPEED, VhciError, attach

NEW = "hub port sta spd dev      sockfd local_busid\n"
LINUX_6_1 = NEW + (
    "hs  0000 006 002 00000007 000012 1-1\n"
    "hs  0001 004 000 00000000 000000 0-0\n"
    "ss  0002 004 000 00000000 000000 0-0\n"
    "ss  0003 004 000 00000000 000000 0-0\n"
)
LINUX_6_1_SECOND = NEW + (
    "hs  0004 004 000 00000000 000000 0-0\nhs  0005 004 000 00000000 000000 0-0\n"
    "ss  0006 004 000 00000000 000000 0-0\nss  0007 004 000 00000000 000000 0-0\n"
)
LINUX_4_14 = (
    "hub port sta spd dev      socket           local_busid\n"
    "hs  0000 006 003 00010002 ffff8800b5a3c000 3-1\n"
    "hs  0001 004 000 00000000 0000000000000000 0-0\n"
    "ss  0008 004 000 00000000 0000000000000000 0-0\n"
)
LINUX_4_9 = (
    "port sta spd dev      socket           local_busid\n"
    "0000 006 003 00010002 ffff8800b5a3c000 3-1\n"
    "0001 004 000 00000000 0000000000000000 0-0\n"
)
LINUX_4_4 = (
    "prt sta spd bus dev socket           local_busid\n"
    "000 006 003 00010002 ffff8800b5a3c000 3-1\n"
    "001 004 000 00000000 0000000000000000 0-0\n"
)


class Sysfs:
    """Folder with the files of the module."""

    def __init__(self, root: Path, name: str = "vhci_hcd.0", **statuses: str) -> None:
        self.root = root
        self.folder = root / "devices/platform" / name
        self.folder.mkdir(parents=True)
        (self.folder / "attach").write_text("")
        for file, text in statuses.items():
            (self.folder / file.replace("_", ".")).write_text(text)

    def asked(self) -> str:
        return (self.folder / "attach").read_text()


@pytest.fixture
def kernel_end() -> Iterator[socket.socket]:
    ours, kernels = socket.socketpair()
    with ours, kernels:
        yield kernels


@pytest.mark.parametrize(
    ("name", "status"),
    [
        ("vhci_hcd.0", LINUX_6_1),
        ("vhci_hcd.0", LINUX_4_14),
        ("vhci_hcd.0", LINUX_4_9),
        ("vhci_hcd", LINUX_4_4),
    ],
)
def test_the_first_free_hub_port_is_taken(
    tmp_path: Path, kernel_end: socket.socket, name: str, status: str
) -> None:
    sysfs = Sysfs(tmp_path, name, status=status)
    made = attach(kernel_end, 7, sysfs=tmp_path)
    assert (made.port, made.controller) == (1, sysfs.folder)
    assert sysfs.asked() == f"1 {kernel_end.fileno()} 7 {FULL_SPEED}"


def test_superspeed_has_hub_ports_of_its_own(tmp_path: Path, kernel_end: socket.socket) -> None:
    Sysfs(tmp_path, status=LINUX_6_1)
    assert attach(kernel_end, 7, SUPER_SPEED, tmp_path).port == 2


def test_the_second_controller_is_used_when_the_first_is_full(
    tmp_path: Path, kernel_end: socket.socket
) -> None:
    Sysfs(tmp_path, status_1=LINUX_6_1_SECOND, status=LINUX_6_1.replace(" 004 ", " 005 "))
    assert attach(kernel_end, 7, sysfs=tmp_path).port == 4


def test_a_hub_port_is_not_taken_before_the_kernel_has_noted_that_the_last_device_left(
    tmp_path: Path, kernel_end: socket.socket
) -> None:
    sysfs = Sysfs(tmp_path, status=LINUX_6_1, status_1=LINUX_6_1_SECOND)
    second = sysfs.folder.with_name("vhci_hcd.1") / "usb3"
    for left in (sysfs.folder / "usb1/1-1", sysfs.folder / "usb1/1-2", second / "3-0:1.0", second / "3-1"):
        left.mkdir(parents=True)
    assert attach(kernel_end, 7, sysfs=tmp_path).port == 5
    leaving = second / "3-2"
    leaving.mkdir()
    with socket.socket() as other, ThreadPoolExecutor() as pool:
        waiting = pool.submit(attach, other, 8, sysfs=tmp_path)
        assert not wait([waiting], timeout=0.2).done
        leaving.rmdir()
        assert waiting.result(timeout=60).port == 5


def test_without_the_module_the_remedy_is_told(tmp_path: Path, kernel_end: socket.socket) -> None:
    with pytest.raises(VhciError, match="modprobe vhci-hcd"):
        attach(kernel_end, 7, sysfs=tmp_path)


def test_when_all_are_taken_it_is_told_how_to_have_more(tmp_path: Path, kernel_end: socket.socket) -> None:
    Sysfs(tmp_path, status=LINUX_6_1.replace(" 004 ", " 006 "))
    with pytest.raises(VhciError, match=r"all 2 hub ports .*CONFIG_USBIP_VHCI_HC_PORTS"):
        attach(kernel_end, 7, sysfs=tmp_path)


@pytest.fixture
def nobody() -> Iterator[Path]:
    """A folder that another user can reach; of root, the test runs on as such a user."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        yield Path(folder)
        if os.getuid() == 0:
            os.seteuid(0)


def test_without_the_right_the_group_is_told(nobody: Path, kernel_end: socket.socket) -> None:
    (Sysfs(nobody, status=LINUX_6_1).folder / "attach").chmod(0)
    if os.getuid() == 0:
        os.seteuid(65534)
    with pytest.raises(VhciError, match=r"may not write .*usermod -aG hil-usb"):
        attach(kernel_end, 7, sysfs=nobody)


def test_what_the_kernel_refuses_otherwise_is_told(tmp_path: Path, kernel_end: socket.socket) -> None:
    sysfs = Sysfs(tmp_path, status=LINUX_6_1)
    (sysfs.folder / "attach").unlink()
    (sysfs.folder / "attach").symlink_to("/dev/full")
    with pytest.raises(VhciError, match=r"refuses the device .No space left"):
        attach(kernel_end, 7, sysfs=tmp_path)


def test_the_tty_is_known_once_the_kernel_has_a_driver_at_it(
    tmp_path: Path, kernel_end: socket.socket
) -> None:
    sysfs = Sysfs(tmp_path, status=LINUX_6_1)
    made = attach(kernel_end, 7, sysfs=tmp_path)
    assert made.tty() is None
    free = "hs  0001 004 000 00000000 000000 0-0"
    status = sysfs.folder / "status"
    status.write_text(LINUX_6_1.replace(free, "hs  0001 006 002 00000007 000013 1-2"))
    assert made.tty() is None
    (tmp_path / "bus/usb/devices/1-1:1.0/tty/ttyACM0").mkdir(parents=True)
    (tmp_path / "bus/usb/devices/1-2:1.0/tty/ttyACM4").mkdir(parents=True)
    assert made.tty() == "/dev/ttyACM4"
    # The number of another device: ours was pulled out, and its place taken.
    status.write_text(LINUX_6_1.replace(free, "hs  0001 006 002 00000008 000014 1-2"))
    assert made.tty() is None
    made.detach()
    assert made.tty() is None


def test_a_device_is_pulled_out_by_the_end_of_its_socket(tmp_path: Path) -> None:
    Sysfs(tmp_path, status=LINUX_6_1)
    ours, kernels = socket.socketpair()
    with ours, socket.socket(fileno=os.dup(kernels.fileno())):  # the kernel has an end of its own
        made = attach(kernels, 7, sysfs=tmp_path)
        made.detach()
        assert ours.recv(1) == b""
        made.detach()
        assert kernels.fileno() == -1
