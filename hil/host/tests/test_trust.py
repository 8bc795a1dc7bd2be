"""Trust in folders by their owners, and the choice of one of the benches in them."""

import os
from pathlib import Path

import pytest

from hil.host import trust
from hil.host.trust import distrust, refuse_address
from hil.net.benches_here import Found, Here

STRANGER_UID = 65534
needs_root = pytest.mark.skipif(os.getuid() != 0, reason="only root can make another user's folder")


def test_own_folders_below_tmp_and_roots_are_believed(tmp_path: Path) -> None:
    assert distrust(tmp_path) == distrust(tmp_path / "not" / "there") == distrust(Path("/run")) == ""
    (tmp_path / "link").symlink_to("real")
    (tmp_path / "real").mkdir()
    assert distrust(tmp_path / "link" / ".." / "real") == ""
    (tmp_path / "circle").symlink_to("circle")
    assert "symbolic links" in distrust(tmp_path / "circle")
    (tmp_path / "file").touch()
    assert distrust(tmp_path / "file" / "x").endswith("file is no folder")


@pytest.mark.parametrize("mode", [0o777, 0o1777])
def test_a_folder_that_all_may_write_is_not(tmp_path: Path, mode: int) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "b").mkdir()
    (tmp_path / "a").chmod(mode)
    assert distrust(tmp_path / "a") == f"{tmp_path}/a may be written by everybody"
    on_the_way = distrust(tmp_path / "a" / "b")
    assert on_the_way == ("" if mode == 0o1777 else f"{tmp_path}/a may be written by everybody")


@needs_root
def test_a_strangers_folder_file_and_link_are_not(tmp_path: Path) -> None:
    for name in ("folder", "folder/below"):
        (tmp_path / name).mkdir()
    os.chown(tmp_path / "folder", STRANGER_UID, STRANGER_UID)
    for asked in ("folder", "folder/below"):
        assert distrust(tmp_path / asked).startswith(
            f"{tmp_path}/folder belongs to another user, nobody (65534)"
        )
        assert distrust(tmp_path / asked, {STRANGER_UID}) == ""
    (tmp_path / "mine").mkdir()
    (tmp_path / "link").symlink_to("mine")
    os.chown(tmp_path / "link", STRANGER_UID, STRANGER_UID, follow_symlinks=False)
    assert "link belongs to another user" in distrust(tmp_path / "link")
    (tmp_path / "grouped").mkdir()
    os.chown(tmp_path / "grouped", 0, STRANGER_UID)
    (tmp_path / "grouped").chmod(0o770)
    assert distrust(tmp_path / "grouped") == f"{tmp_path}/grouped may be written by a group, {STRANGER_UID}"


def test_an_address_is_a_terminal_of_its_owner_or_of_the_network(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    me = os.getuid()
    master, slave = os.openpty()
    name = os.ttyname(slave)
    (tmp_path / "m1").symlink_to(name)
    assert refuse_address(str(tmp_path / "m1"), me) == refuse_address("socket://127.0.0.1:1", me) == ""
    assert "another user" in refuse_address(name, me + 1)
    for wrong in (str(tmp_path / "file"), "/dev/null", "/dev/tty0", str(tmp_path), "/not/there", "m1", ""):
        assert refuse_address(wrong, me)
    for wrong in (f"spy://{name}?file={tmp_path}/file", "alt://x", "/dev/\0", "/" + "x" * 9000):
        assert refuse_address(wrong, me)
    os.close(master)
    os.close(slave)


def test_a_device_at_the_virtual_usb_controller_is_an_address(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trust, "_SYSFS", tmp_path)
    number = os.stat("/dev/null").st_rdev  # in place of a ttyACM's
    link = tmp_path / f"{os.major(number)}:{os.minor(number)}"
    for controller, is_refused in (("platform/vhci_hcd.0/usb5/5-1", False), ("pci0000:00/usb1/1-1", True)):
        tty = tmp_path / "devices" / controller / "tty/ttyACM0"
        tty.mkdir(parents=True)
        link.unlink(missing_ok=True)
        link.symlink_to(tty)
        assert bool(refuse_address("/dev/null", os.getuid() + 1)) == is_refused


def test_benches_of_one_name_have_names_of_their_own(tmp_path: Path) -> None:
    def here(folder: str, is_service: bool) -> Here:
        return Here(tmp_path / folder / "control.sock", 0, is_service)

    own, other, service, alone = (
        here("u/demo", False),
        here("u/x/demo", False),
        here("s/demo", True),
        here("u/b", False),
    )
    found = Found([own, service, alone], [])
    assert found.meant(None) == [own, service, alone]
    assert found.meant("demo") == [own, service]
    assert [found.called(each) for each in found.benches] == [str(own.folder), "service:demo", "b"]
    several = Found([own, other, service], [])
    for some in (found, several):
        for each in some.benches:
            assert some.meant(some.called(each)) == [each]
    assert found.meant("service:b") == found.meant("nix") == found.meant("/nix") == []
