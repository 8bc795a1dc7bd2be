"""Names of recordings in place of paths."""

from pathlib import Path

import pytest

from hil.compose.recordings_folder import ENDING
from hil.recorded.recording_names import NoSuchRecording, bench_of, found_recording, recordings_of


@pytest.fixture
def base(tmp_path: Path) -> Path:
    for bench, date in [
        ("lab", "2026-11-28T23-00-00Z"),
        ("lab", "2026-11-29T00-09-16Z"),
        ("b", "2026-11-29T00-09-15Z"),
    ]:
        folder = tmp_path / bench / "recordings"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{date}{ENDING}").write_bytes(b"")
    return tmp_path


@pytest.mark.parametrize(
    ("text", "bench", "minute"),
    [
        ("last", "lab", "09-16"),
        ("last-0", "lab", "09-16"),
        ("last-1", "b", "09-15"),
        ("last-2", "lab", "00-00"),
        ("lab/last-1", "lab", "00-00"),
        ("b/last", "b", "09-15"),
        ("2026-11-28", "lab", "00-00"),
        ("b/2026", "b", "09-15"),
        ("lab/2026-11-29T00-09-16Z", "lab", "09-16"),
    ],
)
def test_a_name_means_a_recording(base: Path, text: str, bench: str, minute: str) -> None:
    found = found_recording(text, [base])
    assert (bench_of(found), minute in found.name) == (bench, True)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("last-3", "there are 3 recordings in "),
        ("c/last", "there is no recording of c in "),
        (
            "2026-11-29T00-09",
            "2 recordings begin so: b/2026-11-29T00-09-15Z, lab/2026-11-29T00-09-16Z; write more",
        ),
        ("nope", "No such file or directory, and no recording of this name; write a path, last, "),
        ("/no/such/file", "No such file or directory"),
        ("a/b/c", "No such file or directory"),
        ("", "No such file"),
        ("lab/", "No such file"),
        ("../lab/last", "No such file or directory"),
    ],
)
def test_what_means_none_is_refused(base: Path, text: str, why: str) -> None:
    with pytest.raises(NoSuchRecording) as caught:
        found_recording(text, [base])
    assert why in str(caught.value)


def test_a_file_comes_before_a_name(base: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(base)
    (base / "last").write_text("")
    assert found_recording("last", [base]) == Path("last")
    assert recordings_of([base / "none"]) == []
