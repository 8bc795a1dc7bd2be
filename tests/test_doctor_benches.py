"""``hil doctor`` about a bench that takes requests and does not answer them."""

import os
import socket
import time
from pathlib import Path

import pytest

from hil.cli.bench import doctor_benches
from hil.host.doctor import Diagnosis


def judged(tmp_path: Path, age_s: float, mode: int) -> Diagnosis:
    folder = tmp_path / "hil" / "b"
    folder.mkdir(parents=True)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(folder / "control.sock"))
        listener.listen()
        (folder / "control.sock").chmod(mode)
        at_s = time.time() - age_s
        os.utime(folder / "control.sock", (at_s, at_s))
        (finding,) = doctor_benches.judge_benches(tmp_path / "hil", is_named=True)
    return finding


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor_benches, "PATIENCE_S", 0.1)
    monkeypatch.setattr(doctor_benches, "SERVICES", Path("/nonexistent"))


def test_one_that_starts_is_waited_for(tmp_path: Path) -> None:
    finding = judged(tmp_path, 5.0, 0o760)
    assert finding.verdict == "note"
    assert finding.found.endswith("has been starting for 5 s")
    assert "kill" not in (finding.remedy or "")


@pytest.mark.parametrize(("age_s", "mode"), [(3600.0, 0o760), (3600.0, 0o660), (5.0, 0o660)])
def test_one_that_hangs_is_to_be_killed(tmp_path: Path, age_s: float, mode: int) -> None:
    finding = judged(tmp_path, age_s, mode)
    assert finding.verdict == "problem"
    assert f"kill -9 {os.getpid()}" in (finding.remedy or "")
