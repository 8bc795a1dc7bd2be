"""What ``write-a-test.md`` says of programs that wait for a bench: ``--json`` and ``--ready-file``."""

import json

import pytest
from e2e_support import Place, config, until


@pytest.mark.thorough
def test_serve_tells_programs_when_boards_answer(place: Place) -> None:
    ready = place.folder / "ready.json"
    server = place.launch(config(), "--json", "--ready-file", str(ready))
    until(ready.exists, "the boards")
    told = json.loads(ready.read_text())
    assert json.loads(server.output) == told
    assert told["sim_ns"] >= 4_050_000_000
    assert told["pid"] == server.pid
    assert told["ports"] == {"m1": str(place.runtime / "t" / "m1")}
    server.stop()
    assert not ready.exists()
    nowhere = str(place.folder / "no" / "ready.json")
    said = place.launch(config(), "--ready-file", nowhere).refused()
    why = f"there is no folder {place.folder}/no; make it with mkdir, or write another path"
    assert said == f"hil: --ready-file {nowhere}: {why}\n"
