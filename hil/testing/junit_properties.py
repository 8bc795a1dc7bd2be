"""Properties of a test in JUnit's XML: on which benches it ran."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import pytest

from hil import __version__
from hil.vocab.text_digest import text_digest

if TYPE_CHECKING:
    from hil.testing.bench import Bench
    from hil.testing.served_bench import ServedBench

_NOTED = pytest.StashKey[set[int]]()


def note_benches(item: pytest.Item, benches: "Sequence[Bench]", live: "Sequence[ServedBench]") -> None:
    """Note the benches that a test has, each once, if pytest writes such a file (``--junitxml``)."""
    if not item.config.getoption("xmlpath", None):
        return
    noted = item.stash.setdefault(_NOTED, set())
    of_memory, of_live = (
        ((id(each), _of_memory(each)) for each in benches),
        ((id(each), _of_live(each)) for each in live),
    )
    for number, properties in (*of_memory, *of_live):
        if number not in noted:
            noted.add(number)
            which = f".{len(noted)}" if len(noted) > 1 else ""
            item.user_properties.extend((f"hil.{name}{which}", value) for name, value in properties)


def _of_memory(bench: "Bench") -> Iterator[tuple[str, str]]:
    yield "bench", bench.config.bench
    yield "kind", "virtual"
    yield "version", __version__
    yield "seed", str(bench.seed)
    yield "config_digest", text_digest(bench.config.model_dump_json(by_alias=True))


def _of_live(bench: "ServedBench") -> Iterator[tuple[str, str]]:
    """Properties of a bench in a process, which may have ended by now."""
    from hil.testing.live_desk import LiveError

    yield "recording", str(bench.recording_file)
    try:
        about = bench.desk.ask("about")
        yield "kind", bench.kind
    except LiveError:
        return
    for name in ("bench", "version", "host", "config_digest"):
        yield name, str(about[name])
    if lease := about["lease"]:
        yield "lease", f"{lease['user']}: {lease['why']}"
