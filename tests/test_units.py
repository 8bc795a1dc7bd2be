"""The systemd units as files: what systemd-analyze says of them, and where they are installed."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
UNITS = ROOT / "systemd"
DROP_INS = ("adapters", "can", "network", "realtime", "usb")
needs_analyze = pytest.mark.skipif(not shutil.which("systemd-analyze"), reason="no systemd-analyze here")


def directives(text: str, name: str) -> list[str]:
    return re.findall(rf"^{name}=(.*)$", text, re.M)


def analyze(folder: Path, *arguments: str) -> str:
    """Output of ``systemd-analyze``; the units of the folder are the only ones that it finds first."""
    done = subprocess.run(
        ["systemd-analyze", "--no-pager", *arguments],
        env=os.environ | {"SYSTEMD_UNIT_PATH": f"{folder}:", "LC_ALL": "C.UTF-8"},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def unit_folder(folder: Path, drop_ins: tuple[str, ...]) -> Path:
    """The units with programs that exist: ``verify`` looks for them."""
    for unit in ("hil.service", "hil@.service"):
        text = (UNITS / unit).read_text().replace("/usr/local/bin/hil", "/bin/true")
        (folder / unit).write_text(text)
        for drop_in in drop_ins:
            (folder / f"{unit}.d").mkdir(exist_ok=True)
            shutil.copy(UNITS / f"{drop_in}.conf", folder / f"{unit}.d")
    return folder


def documented_scores() -> dict[str, str]:
    """The table of docs/how-to/service.md: drop-ins and the score with them."""
    text = (ROOT / "docs/how-to/service.md").read_text()
    return dict(re.findall(r"^\| ([\w ,`.]+?) +\| (\d\.\d) +\|", text, re.M))


@needs_analyze
@pytest.mark.parametrize(
    ("title", "drop_ins"),
    [
        ("the unit alone", ()),
        *((f"`{name}.conf`", (name,)) for name in DROP_INS),
        ("all but `can.conf`", tuple(name for name in DROP_INS if name != "can")),
    ],
)
def test_exposure_is_as_documented(title: str, drop_ins: tuple[str, ...], tmp_path: Path) -> None:
    folder = unit_folder(tmp_path, drop_ins)
    for unit in ("hil.service", "hil@.service"):
        said = analyze(folder, "security", "--offline=yes", unit)
        score = re.search(r"Overall exposure level for \S+: (\d\.\d)", said)
        assert score, said
        assert float(score[1]) <= 2.0, said
        assert score[1] == documented_scores()[title], said


@needs_analyze
@pytest.mark.parametrize("drop_ins", [(), DROP_INS])
def test_systemd_finds_no_fault_with_the_units(drop_ins: tuple[str, ...], tmp_path: Path) -> None:
    folder = unit_folder(tmp_path, drop_ins)
    said = analyze(folder, "verify", "--man=no", str(folder / "hil.service"), str(folder / "hil@lab.service"))
    assert not [line for line in said.splitlines() if "hil" in line], said


def test_the_two_units_differ_in_names_alone() -> None:
    single, template = ((UNITS / unit).read_text() for unit in ("hil.service", "hil@.service"))
    named = single.replace("/etc/hil/bench.yaml", "/etc/hil/%i.yaml").replace("hil/bench\n", "hil/%i\n")

    def body(text: str) -> list[str]:
        return [line for line in text.splitlines() if not line.startswith(("#", "Description="))]

    assert body(named) == body(template)


def test_the_limit_of_locked_memory_is_that_of_the_largest_bench() -> None:
    """16 MiB and 64 KiB for each axis is what is promised (``test_e2e_locked_memory``)."""
    limit = directives((UNITS / "hil.service").read_text(), "LimitMEMLOCK")
    assert limit == [f"{-(-(16 * 1024 + 450 * 64) // 1024)}M"]


def test_install_and_uninstall_leave_nothing(tmp_path: Path) -> None:
    env = os.environ | {"DESTDIR": str(tmp_path), "PREFIX": "/opt/h"}
    script = str(UNITS / "install.sh")
    subprocess.run([script], env=env, check=True, timeout=60)
    unit = (tmp_path / "opt/h/lib/systemd/system/hil@.service").read_text()
    assert directives(unit, "ExecStart") == ["/opt/h/bin/hil serve --port-group dialout /etc/hil/%i.yaml"]
    assert directives(unit, "ExecReload") == ["/opt/h/bin/hil reload"]
    assert {path.name for path in (tmp_path / "opt/h/share/hil/systemd").iterdir()} == {
        *(f"{name}.conf" for name in DROP_INS),
        *("usb-modules.conf", "usb.rules"),
    }
    subprocess.run([script, "--uninstall"], env=env, check=True, timeout=60)
    assert [path for path in tmp_path.rglob("*") if not path.is_dir()] == []
