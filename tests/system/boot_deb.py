"""The Debian package in a booted Debian: installed without a network, started with a configuration, restarted
by an upgrade, stopped by a removal."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from container import Container, until
from debian import INSTALL_S, ROOT, CannotError, bare_tree, need, run

BENCH = "bench: bench\ndevices:\n  m1: {profile: mechaduino, flash: {table: identity}}\n"
ASK = (
    "import serial; s = serial.serial_for_url('/run/hil/bench/m1', 115200, timeout=10);"
    "s.write(b'm'); print(s.read_until(b'menu'))"
)
UNIT = "hil.service"


@pytest.fixture(scope="module")
def machine() -> Iterator[Container]:
    """Container with ``/hil.deb`` in it; HIL_DEB: a package that is built already."""
    try:
        need({"systemd-nspawn": "systemd-container", "nsenter": "util-linux", "dpkg-shlibdeps": "dpkg-dev"})
        bare = bare_tree()
        with tempfile.TemporaryDirectory(prefix="hil-deb-") as folder:
            if not (built := os.environ.get("HIL_DEB")):
                run(ROOT / "packaging/deb/build", timeout_s=INSTALL_S)
                built = str(max((ROOT / "dist").glob("hil_*.deb"), key=lambda path: path.stat().st_mtime))
            tree = Path(folder) / "tree"
            run("cp", "-a", "--reflink=auto", bare, tree)
            shutil.copy(built, tree / "hil.deb")
            for user in ("tester", "stranger"):
                subprocess.run(["chroot", tree, "useradd", "--create-home", user], check=True)
            with Container(tree) as container:
                yield container
    except CannotError as error:
        pytest.skip(str(error))


def show(machine: Container, what: str) -> str:
    return machine.run("systemctl", "show", "--value", "-p", what, UNIT).strip()


def test_installed_without_a_configuration_nothing_is_started(machine: Container) -> None:
    machine.run("dpkg", "-i", "/hil.deb", timeout_s=INSTALL_S)
    assert machine.run("dpkg", "--audit") == ""
    assert show(machine, "ActiveState") == "inactive"
    assert show(machine, "LoadState") == "loaded"


def test_with_a_configuration_it_serves_users_of_dialout(machine: Container) -> None:
    machine.path("/etc/hil/bench.yaml").write_text(BENCH)
    machine.run("systemctl", "enable", "--now", UNIT)
    until(lambda: machine.path("/run/hil/bench/m1").is_symlink(), "the port")
    assert show(machine, "ActiveState") == "active"
    machine.run("gpasswd", "--add", "tester", "dialout")
    until(lambda: b"menu" in asked(machine), "the board's boot", every_s=0.5)
    assert "m1" in machine.run("hil", "list")
    assert "Permission denied" in machine.run(
        "/usr/lib/hil/bin/python3", "-c", ASK, user="stranger", check=False
    )


def asked(machine: Container) -> bytes:
    said = machine.run("/usr/lib/hil/bin/python3", "-c", ASK, user="tester", check=False)
    return said.encode()


def test_an_upgrade_restarts_it(machine: Container) -> None:
    pid = show(machine, "MainPID")
    machine.run("dpkg", "-i", "/hil.deb", timeout_s=INSTALL_S)
    until(lambda: show(machine, "ActiveState") == "active", "the service")
    assert show(machine, "MainPID") not in ("0", pid)
    until(lambda: machine.path("/run/hil/bench/m1").is_symlink(), "the port")


def test_a_removal_stops_it_and_a_purge_forgets_it(machine: Container) -> None:
    machine.run("dpkg", "-r", "hil", timeout_s=INSTALL_S)
    assert not machine.path("/run/hil/bench").exists()
    assert machine.run("systemctl", "is-active", UNIT, check=False).strip() == "inactive"
    assert machine.path("/etc/hil/bench.yaml").exists()
    machine.run("dpkg", "-P", "hil", timeout_s=INSTALL_S)
    assert not machine.path("/var/lib/private/hil").exists()
    assert machine.path("/etc/hil/bench.yaml").read_text() == BENCH
