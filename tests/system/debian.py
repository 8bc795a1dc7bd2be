"""A tree of Debian 12 with hil installed in it, as an administrator installs it.

The bare tree is made once, by debootstrap, and kept in ``$HIL_TEST_SYSTEM`` (``~/.cache/hil-test-system``).
"""

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
MIRROR = os.environ.get("HIL_DEBIAN_MIRROR", "http://deb.debian.org/debian")
CACHE = Path(
    os.environ.get("HIL_TEST_SYSTEM")
    or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hil-test-system"
)
PACKAGES = "systemd,systemd-sysv,dbus,python3,python3-venv,make,procps,kmod,e2fsprogs"
INSTALL_S = 900
UNUSED_DRIVERS = ("gpu", "media", "infiniband", "scsi")
"""Kinds of drivers that a virtual machine does not need."""
HIL_PYTHON = "/usr/local/lib/hil/bin/python"


class CannotError(Exception):
    """Error of a machine that cannot run the test: ``str(error)`` says why."""


def need(programs: dict[str, str]) -> None:
    """Require programs, each with the Debian package to have it from; install what is missing, where that is
    allowed.

    Raises:
        CannotError: one is missing.
    """
    if os.getuid() != 0:
        raise CannotError("only root can boot a system of its own")
    if platform.machine() != "x86_64":
        raise CannotError(f"only tried on x86_64, not on {platform.machine()}")
    missing = [package for program, package in programs.items() if not shutil.which(program)]
    if missing and shutil.which("apt-get"):
        command = ["apt-get", "install", "-y", "-qq", "--no-install-recommends", *missing]
        environment = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
        for each in (["apt-get", "update", "-qq"], command):
            subprocess.run(each, env=environment, stdout=subprocess.DEVNULL, timeout=INSTALL_S, check=False)
        missing = [package for program, package in programs.items() if not shutil.which(program)]
    if missing:
        raise CannotError(f"missing here, as Debian calls them: {' '.join(missing)}")


def run(*command: str | Path, timeout_s: float = INSTALL_S) -> str:
    """Run a command, and return its output.

    Raises:
        CannotError: it failed.
    """
    done = subprocess.run(
        [str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=timeout_s
    )
    said = done.stdout.decode(errors="replace")
    if done.returncode:
        raise CannotError(f"{' '.join(map(str, command))}: {said[-600:]}")
    return said


def bare_tree() -> Path:
    """Debian as debootstrap makes it, from the cache if it is there."""
    need({"debootstrap": "debootstrap"})
    tree = CACHE / "bookworm"
    if not tree.exists():
        CACHE.mkdir(parents=True, exist_ok=True)
        unfinished = CACHE / "bookworm.unfinished"
        shutil.rmtree(unfinished, ignore_errors=True)
        run("debootstrap", "--variant=minbase", f"--include={PACKAGES}", "bookworm", unfinished, MIRROR)
        unfinished.rename(tree)
    return tree


def wheels(folder: Path) -> Path:
    """Build this project's wheel and those of what it depends on, or copy them from ``$HIL_WHEELS`` if that
    is set.

    Raises:
        CannotError: this machine's Python is not Debian's, whose wheels they have to be.
    """
    if built := os.environ.get("HIL_WHEELS"):
        shutil.copytree(built, folder)
        return folder
    version = platform.python_version()
    if sys.version_info[:2] != (3, 11):
        raise CannotError(f"wheels for Debian 12 are built by Python 3.11, this is {version}: set HIL_WHEELS")
    shutil.rmtree(ROOT / "build", ignore_errors=True)  # what was deleted since is still in there
    run(sys.executable, "-m", "pip", "wheel", "-q", "--disable-pip-version-check", "-w", folder, ROOT)
    return folder


def tree_with_hil(folder: Path, bare: Path) -> Path:
    """A copy of the bare tree in which ``make install-service`` was run."""
    tree = folder / "tree"
    run("cp", "-a", "--reflink=auto", bare, tree)
    wheels(tree / "wheels")
    (wheel,) = (tree / "wheels").glob("hil_motion-*.whl")
    shutil.copy(ROOT / "Makefile", tree / "wheels")
    run(
        *("chroot", tree, "env", "-i", "PATH=/usr/sbin:/usr/bin:/sbin:/bin"),
        *("PIP_NO_INDEX=1", "PIP_FIND_LINKS=/wheels"),
        *("make", "-C", "/wheels", "install-service", f"WHEEL=/wheels/{wheel.name}"),
    )
    return tree


def tree_with_kernel() -> Path:
    """The bare tree with Debian's real-time kernel and tools of CAN, from the cache if it is there."""
    packages = ("linux-image-rt-amd64", "iproute2", "can-utils")
    return _tree_with("bookworm-rt-can", packages, (*UNUSED_DRIVERS, "usb"))


def tree_with_usb() -> Path:
    """The bare tree with both of Debian's kernels, udev, and programs for serial ports, from the cache if it
    is there."""
    packages = (
        *("linux-image-amd64", "linux-image-rt-amd64", "udev", "usbutils", "python3-serial", "python3-usb"),
        *("picocom", "tio", "minicom", "screen", "putty-tools"),
        *(
            "arduino",
            "cutecom",
            "gtkterm",
            "xvfb",
            "openbox",
            "xdotool",
            "imagemagick",
            "x11-utils",
            "psmisc",
        ),
    )
    return _tree_with("bookworm-usb", packages, UNUSED_DRIVERS)


def _tree_with(name: str, packages: tuple[str, ...], without: tuple[str, ...]) -> Path:
    """The bare tree with packages, of kernels too, whose drivers of some kinds are taken out."""
    tree = CACHE / name
    if not tree.exists():
        unfinished = CACHE / f"{name}.unfinished"
        shutil.rmtree(unfinished, ignore_errors=True)
        run("cp", "-a", "--reflink=auto", bare_tree(), unfinished)
        initramfs = unfinished / "etc/initramfs-tools"
        (initramfs / "conf.d").mkdir(parents=True)
        # An initial disk for this machine alone: an emulated CPU is long at unpacking the usual one.
        (initramfs / "conf.d/small").write_text("MODULES=list\n")
        (initramfs / "modules").write_text("virtio_pci\nvirtio_blk\next4\n")
        # Packages of Java look into /proc as they are installed.
        within = ("unshare", "--mount", "sh", "-ec", 'mount -t proc proc "$1/proc"; exec chroot "$@"', "sh")
        apt = (*within, unfinished, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq")
        run(*apt, "update")
        run(*apt, "install", "-y", "--no-install-recommends", "initramfs-tools", *packages)
        run(*apt, "clean")
        for unused in unfinished.glob("lib/modules/*/kernel/sound"):
            shutil.rmtree(unused)
        for unused in unfinished.glob("lib/modules/*/kernel/drivers/*"):
            if unused.name in without:
                shutil.rmtree(unused)
        unfinished.rename(tree)
    return tree
