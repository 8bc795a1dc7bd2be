"""``hil usb doctor``: checks that the kernel can have virtual USB devices, and that the user may plug them
in. All is read below a root, so that a folder can stand for any system."""

import os
import re
from collections.abc import Iterator
from errno import EACCES, EPERM, EROFS
from pathlib import Path

from hil.cli.framework.command_answers import AsJson
from hil.cli.framework.installed_files import installed
from hil.host.doctor import Diagnosis, worst_first
from hil.host.system import Files, group_number, kernel_config
from hil.net.usb_hub import FREE, GROUP, controller, hub_ports

NO_PORT = "no port of kind `usb` opens"
CAUTION = "who may write it can plug in any USB device, a keyboard too"
_HC_PORTS, _NR_HCS = "CONFIG_USBIP_VHCI_HC_PORTS", "CONFIG_USBIP_VHCI_NR_HCS"
MORE_PORTS = f"stop another bench; or a kernel built with a greater {_HC_PORTS} (at most 15) or {_NR_HCS}"
AT_BOOT = ("etc/modules", "etc/modules-load.d/*.conf", "run/modules-load.d/*.conf")
AT_BOOT_SHIPPED = ("usr/local/lib/modules-load.d/*.conf", "usr/lib/modules-load.d/*.conf")
"""Files of modules that systemd loads at boot: modules-load.d(5)."""


def doctor(as_json: AsJson = False) -> None:
    """Check whether this system can have virtual USB devices, and you may plug them in.

    Prints each problem, its effect, and the line that corrects it. Exits with 1 if something is missing
    without which no port of kind usb opens.

    Example: hil usb doctor
    """
    from hil.cli.bench.views import tell_findings

    tell_findings(worst_first(list(judge_usb())), as_json)


def judge_usb(root: Path = Path("/")) -> Iterator[Diagnosis]:
    """Make one finding for each thing that a port of kind ``usb`` needs."""
    files = Files(root)
    kernel = files.text("/proc/sys/kernel/osrelease") or ""
    yield _module(root, files, kernel)
    if folder := controller(root / "sys"):
        yield _right(folder, root)
        yield _ports(folder)
        yield _boot(root, kernel)
    yield _driver(root, files, kernel)
    yield _udev(root)


def _module(root: Path, files: Files, kernel: str) -> Diagnosis:
    name = "module vhci-hcd"
    if controller(root / "sys"):
        return Diagnosis(name, "ok", "loaded")
    there, built = _has(root, kernel, "vhci-hcd"), _option(files, "CONFIG_USBIP_VHCI_HCD")
    remedy = "as root `modprobe vhci-hcd`"
    if there:
        found = "not loaded"
    elif built == "n":
        found = f"Linux {kernel} was built without it (CONFIG_USBIP_VHCI_HCD is not set)"
        remedy = "a kernel with CONFIG_USBIP_CORE and CONFIG_USBIP_VHCI_HCD, as `linux-image-amd64` of Debian"
    elif there is None:
        found = f"not loaded, and no /lib/modules/{kernel} here says whether this kernel has it"
        remedy += "; of a container or WSL, on the host whose kernel it is"
    else:
        found = "not installed" + (", though this kernel was built with it" if built else "")
        remedy = "install all of this kernel's modules, as `linux-modules-extra-$(uname -r)` of Ubuntu"
    return Diagnosis(name, "problem", found, NO_PORT, remedy)


def _option(files: Files, name: str) -> str:
    """Value of a kernel's option: y, m or n; empty: its configuration is not here."""
    config = kernel_config(files)
    found = re.search(rf"^{name}=(\w)", config, re.M)
    return found[1] if found else "n" if config else ""


def _right(folder: Path, root: Path) -> Diagnosis:
    name, attach = "right to plug in", folder / "attach"
    shown = f"/{attach.relative_to(root)}"
    try:
        mode = attach.stat().st_mode
        os.close(os.open(attach, os.O_WRONLY))
    except OSError as error:
        found = f"{shown} refuses you: {error.strerror}"
        if error.errno == EROFS:
            remedy = "of the service, link the drop-in usb.conf: `hil docs service`"
        elif error.errno in (EACCES, EPERM):
            remedy = f"as root {_grant(attach, shown, root)}, then log in again; {CAUTION}"
        else:
            remedy = "as root `modprobe -r vhci-hcd` and `modprobe vhci-hcd`"
        return Diagnosis(name, "problem", found, NO_PORT, remedy)
    if mode & 0o002:
        found = f"{shown} can be written by everybody"
        return Diagnosis(name, "note", found, CAUTION, f"as root `chmod o-w {shown}`")
    return Diagnosis(name, "ok", f"{shown} can be written")


def _grant(attach: Path, shown: str, root: Path) -> str:
    """Commands that make the user one of the group, and give it the right, where that is not done yet."""
    files = Files(root)
    number = group_number(files, GROUP)
    commands = [] if number is not None else [f"groupadd --system {GROUP}"]
    if number != attach.stat().st_gid and _udev_runs(root):
        commands += [
            _link("usb.rules", "/etc/udev/rules.d/60-hil-usb.rules"),
            "udevadm control --reload",
            f"udevadm trigger --action=add {Path(shown).parent}",
        ]
    elif number != attach.stat().st_gid:
        commands += [f"chgrp {GROUP} {shown}", f"chmod g+w {shown}"]
    return f"`{' && '.join([*commands, f'usermod -aG {GROUP} USER'])}`"


def _ports(folder: Path) -> Diagnosis:
    name = "hub ports"
    try:
        ports = [port for port in hub_ports(folder) if not port.is_super]
    except OSError as error:
        return Diagnosis(
            name, "problem", f"they cannot be read: {error.strerror}", NO_PORT, "`dmesg | grep vhci`"
        )
    free = sum(port.state == FREE for port in ports)
    found = f"{len(ports) - free} of {len(ports)} in use"
    if free:
        return Diagnosis(name, "ok", found)
    return Diagnosis(name, "problem", found, "no more ports of kind `usb` open", MORE_PORTS)


def _boot(root: Path, kernel: str) -> Diagnosis:
    name = "loaded at boot"
    if "vhci-hcd" in _words(root / f"lib/modules/{kernel}/modules.builtin"):
        return Diagnosis(name, "ok", "built into the kernel")
    for pattern in (*AT_BOOT, *AT_BOOT_SHIPPED):
        for path in sorted(root.glob(pattern)):
            if "vhci-hcd" in _words(path):
                return Diagnosis(name, "ok", f"/{path.relative_to(root)}")
    remedy = f"as root `{_link('usb-modules.conf', '/etc/modules-load.d/hil-usb.conf')}`"
    return Diagnosis(name, "note", "no", f"after the next boot {NO_PORT}", remedy)


def _driver(root: Path, files: Files, kernel: str) -> Diagnosis:
    name, cost = "driver cdc_acm", "devices appear without a /dev/ttyACM*"
    if (root / "sys/bus/usb/drivers/cdc_acm").exists():
        return Diagnosis(name, "ok", "loaded")
    there = _has(root, kernel, "cdc-acm")
    if there and _udev_runs(root):
        return Diagnosis(name, "ok", "there; it is loaded with the first device")
    if there is False or _option(files, "CONFIG_USB_ACM") == "n":
        remedy = "a kernel with CONFIG_USB_ACM, or the rest of this one's modules"
        return Diagnosis(name, "problem", "this kernel has none", cost, remedy)
    return Diagnosis(name, "problem", "not loaded", cost, "as root `modprobe cdc-acm`")


def _udev(root: Path) -> Diagnosis:
    if _udev_runs(root):
        return Diagnosis("udev", "ok", "it runs")
    cost = "no /dev/serial/by-id, and /dev/ttyACM* are for root alone"
    return Diagnosis("udev", "note", "it does not run", cost, "install it, as `udev` of Debian")


def _udev_runs(root: Path) -> bool:
    return (root / "run/udev/control").exists()


def _has(root: Path, kernel: str, module: str) -> bool | None:
    """True if the kernel has a module, loaded or not; None: its list of modules is not here."""
    folder = root / "lib/modules" / kernel
    lists = [path for name in ("modules.dep", "modules.builtin") if (path := folder / name).exists()]
    if not kernel or not lists:
        return None
    return any(module in _words(path) for path in lists)


def _words(path: Path) -> set[str]:
    """Names of modules in a file, whether they stand as paths or alone, with - for _."""
    text = path.read_text(errors="replace") if path.exists() else ""
    lines = (line.split(":")[0].strip() for line in text.splitlines() if not line.startswith(("#", ";")))
    return {line.rpartition("/")[2].partition(".ko")[0].replace("_", "-") for line in lines}


def _link(name: str, place: str) -> str:
    """Command that makes a shipped file count."""
    return f"ln -s {installed('systemd') or '.../systemd'}/{name} {place}"
