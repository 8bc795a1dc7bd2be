"""Findings of ``hil usb doctor``, about systems that are folders with the files that matter."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from hil.cli.bench.doctor_usb import judge_usb
from hil.host.doctor import Diagnosis

KERNEL = "6.1.0-50-amd64"
STATUS = (
    "hub port sta spd dev      sockfd local_busid\n"
    "hs  0000 006 002 00000001 000012 1-1\nhs  0001 004 000 00000000 000000 0-0\n"
    "ss  0002 004 000 00000000 000000 0-0\n"
)
ATTACH = "sys/devices/platform/vhci_hcd.0/attach"
LISTED = f"lib/modules/{KERNEL}/modules.dep"
CONFIG = f"boot/config-{KERNEL}"
GOOD = {
    "proc/sys/kernel/osrelease": f"{KERNEL}\n",
    CONFIG: "CONFIG_USBIP_VHCI_HCD=m\nCONFIG_USB_ACM=m\n",
    LISTED: "kernel/drivers/usb/usbip/vhci-hcd.ko: kernel/drivers/usb/usbip/usbip-core.ko\n"
    "kernel/drivers/usb/class/cdc-acm.ko.xz:\n",
    ATTACH: "",
    "sys/devices/platform/vhci_hcd.0/status": STATUS,
    "etc/modules-load.d/hil-usb.conf": "# for hil\nvhci_hcd\n",
    "etc/group": "root:x:0:\nhil-usb:x:990:\n",
    "run/udev/control": "",
}
UNLOADED = {ATTACH: None}


@pytest.fixture
def root() -> Iterator[Path]:
    """A folder that another user can reach. A test may run on as such a user."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        yield Path(folder)
        if os.getuid() == 0:
            os.seteuid(0)


def findings(root: Path) -> dict[str, Diagnosis]:
    return {finding.name: finding for finding in judge_usb(root)}


def judged(root: Path, files: dict[str, str | None] | None = None) -> dict[str, Diagnosis]:
    for path, text in (GOOD | (files or {})).items():
        if text is not None:
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(text)
    return findings(root)


def refused(root: Path, files: dict[str, str | None] | None = None, group: int = 0) -> Diagnosis:
    """Finding about the right, of a user who may not write ``attach``, which has this group."""
    judged(root, files)
    (root / ATTACH).chmod(0)
    if os.getuid() == 0:
        os.chown(root / ATTACH, 0, group)
        os.seteuid(65534)
    finding = findings(root)["right to plug in"]
    assert finding.verdict == "problem"
    assert "/attach refuses you: Permission denied" in finding.found
    assert finding.remedy.endswith("a keyboard too")
    return finding


def test_a_system_that_has_it_all_is_ok_throughout(root: Path) -> None:
    found = judged(root)
    assert [finding for finding in found.values() if finding.verdict != "ok"] == []
    assert found["hub ports"].found == "1 of 2 in use"
    assert found["loaded at boot"].found == "/etc/modules-load.d/hil-usb.conf"


@pytest.mark.parametrize(
    ("files", "found", "remedy"),
    [
        ({}, "not loaded", "as root `modprobe vhci-hcd`"),
        ({CONFIG: None}, "not loaded", "as root `modprobe vhci-hcd`"),
        (
            {LISTED: "", CONFIG: "# CONFIG_USBIP_VHCI_HCD is not set\n"},
            "CONFIG_USBIP_VHCI_HCD is not set",
            "linux-image-amd64",
        ),
        ({LISTED: ""}, "not installed, though this kernel was built with it", "linux-modules-extra"),
        ({LISTED: "", CONFIG: None}, "not installed", "linux-modules-extra"),
        ({LISTED: None}, f"no /lib/modules/{KERNEL} here", "on the host"),
    ],
)
def test_without_the_module_it_is_told_where_it_is(
    root: Path, files: dict[str, str | None], found: str, remedy: str
) -> None:
    judgements = judged(root, UNLOADED | files)
    finding = judgements["module vhci-hcd"]
    assert finding.verdict == "problem"
    assert found in finding.found
    assert remedy in finding.remedy
    assert "hub ports" not in judgements, "nothing more can be said of it"


def test_hub_ports_that_are_all_taken(root: Path) -> None:
    full = {"sys/devices/platform/vhci_hcd.0/status": STATUS.replace(" 004 ", " 006 ")}
    finding = judged(root, full)["hub ports"]
    assert (finding.verdict, finding.found) == ("problem", "2 of 2 in use")
    assert "CONFIG_USBIP_VHCI_HC_PORTS" in finding.remedy


def test_without_the_right_the_commands_that_give_it_are_told(root: Path) -> None:
    remedy = refused(root).remedy
    assert "groupadd" not in remedy
    assert "usb.rules /etc/udev/rules.d/60-hil-usb.rules && udevadm control --reload" in remedy
    assert "&& usermod -aG hil-usb USER`, then log in again" in remedy


@pytest.mark.skipif(os.getuid() != 0, reason="only root gives a file to another group")
def test_where_the_group_has_the_right_only_the_membership_is_told(root: Path) -> None:
    remedy = refused(root, group=990).remedy
    assert remedy.startswith("as root `usermod -aG hil-usb USER`, then log in again")


def test_without_udev_and_group_the_right_is_given_by_hand(root: Path) -> None:
    remedy = refused(root, {"run/udev/control": None, "etc/group": ""}).remedy
    assert "`groupadd --system hil-usb && chgrp hil-usb /sys/" in remedy


def test_a_right_of_everybody_is_worth_a_note(root: Path) -> None:
    judged(root)
    (root / ATTACH).chmod(0o666)
    finding = findings(root)["right to plug in"]
    assert finding.verdict == "note"
    assert finding.cost.endswith("a keyboard too")


def test_a_module_that_is_loaded_by_hand_is_gone_after_a_boot(root: Path) -> None:
    finding = judged(root, {"etc/modules-load.d/hil-usb.conf": "# vhci-hcd\n"})["loaded at boot"]
    assert finding.verdict == "note"
    assert finding.remedy.endswith("usb-modules.conf /etc/modules-load.d/hil-usb.conf`")


def test_a_driver_that_is_missing(root: Path) -> None:
    only_vhci = "kernel/drivers/usb/usbip/vhci-hcd.ko:\n"
    finding = judged(root, {LISTED: only_vhci})["driver cdc_acm"]
    assert (finding.verdict, finding.found) == ("problem", "this kernel has none")
    (root / LISTED).write_text(GOOD[LISTED])
    (root / "run/udev/control").unlink()
    finding = findings(root)["driver cdc_acm"]
    assert finding.remedy == "as root `modprobe cdc-acm`"
    (root / "sys/bus/usb/drivers/cdc_acm").mkdir(parents=True)
    assert findings(root)["driver cdc_acm"].verdict == "ok"
