"""Slips of who writes a test: each is a sentence with what is taken instead."""

import json
from pathlib import Path
from typing import Any

import pytest

from hil.testing import Bench, ConfigError, LiveError, live
from hil.testing.config_reading import read_config

ONE = {"bench": "kit", "devices": {"m1": {"profile": "mechaduino"}}}
BUS = ONE | {
    "can": {"can0": {"bit_rate": 1_000_000, "nodes": {"m1": 5}, "taps": {"slcan0": {"port": "pty"}}}}
}
NO_CONFIGURATIONS = ([1], None, 7, b"bench.yaml", {"bench"})
"""Objects that are no path, no text and no dict."""


@pytest.fixture(scope="module")
def kit() -> Bench:
    return Bench(BUS)


def _frames(raised: pytest.ExceptionInfo[BaseException]) -> list[str]:
    """Files of the frames that pytest shows."""
    return [Path(str(entry.path)).name for entry in raised.traceback if not entry.ishidden(raised)]


@pytest.mark.parametrize("as_text", [True, False])
def test_a_file_that_is_not_there_is_a_configuration_error(
    as_text: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    given: Any = "nofile.yaml" if as_text else Path("nofile.yaml")
    with pytest.raises(ConfigError) as raised:
        Bench(given)
    assert (
        str(raised.value)
        == f"nofile.yaml: No such file or directory (it was looked for at {tmp_path}/nofile.yaml)"
    )
    assert raised.value.problems[0].file == "nofile.yaml"
    assert _frames(raised) == [Path(__file__).name]
    with pytest.raises(LiveError, match="No such file") as live_raised:
        live(given).__enter__()
    assert str(live_raised.value) == str(raised.value)


@pytest.mark.parametrize("content", [None, b"\xff\xfe"])
def test_a_file_that_cannot_be_read_is_a_configuration_error(content: bytes | None, tmp_path: Path) -> None:
    path = tmp_path / "bench.yaml"
    path.mkdir() if content is None else path.write_bytes(content)
    with pytest.raises(ConfigError, match=str(path)):
        read_config(path)


def test_text_that_is_no_path_is_a_configuration_error() -> None:
    with pytest.raises(ConfigError, match="the file is empty"):
        read_config("")
    with pytest.raises(ConfigError, match="null byte"):
        read_config("a\0b")


@pytest.mark.parametrize("given", NO_CONFIGURATIONS, ids=repr)
def test_what_is_no_configuration_is_told_what_is(given: Any) -> None:
    with pytest.raises(TypeError) as raised:
        Bench(given)
    assert str(raised.value) == f"a bench is made from a path, YAML text or a dict, not from {given!r}"
    assert _frames(raised) == [Path(__file__).name]
    with pytest.raises(TypeError) as live_raised:
        live(given).__enter__()
    assert str(live_raised.value) == str(raised.value)


def test_the_fixtures_say_it_too(bench: Any, live_bench: Any) -> None:
    with pytest.raises(ConfigError, match="it was looked for at"):
        bench("nofile.yaml")
    for make in (bench, live_bench):
        with pytest.raises(TypeError, match="a bench is made from") as raised:
            make(None)
        assert _frames(raised) == [Path(__file__).name]


def test_a_dict_of_a_live_bench_may_have_what_that_of_a_kits_may(tmp_path: Path) -> None:
    from types import MappingProxyType

    from hil.testing.given import as_json

    table = tmp_path / "table.txt"
    given = MappingProxyType({"devices": {"m1": {"flash": MappingProxyType({"table": table})}}})
    assert json.loads(as_json(given)) == {"devices": {"m1": {"flash": {"table": str(table)}}}}
    with pytest.raises(TypeError, match="an object of type set is no configuration value"):
        as_json({"devices": {"m1"}})


def test_a_pin_that_is_not_there_is_a_sentence(kit: Bench) -> None:
    with pytest.raises(KeyError) as raised:
        kit.device("m1").pin("D77")
    assert str(raised.value) == "m1 has no pin 'D77'; there are D0, D1, D2, D3, dir, step, enable"
    with pytest.raises(KeyError) as raised:
        kit.device("m1").pin("elbow.D0")
    assert str(raised.value) == "m1 has no axis 'elbow'; it has axis"


def test_names_on_a_bus_are_sentences(kit: Bench) -> None:
    bus = kit.canbus()
    with pytest.raises(KeyError) as raised:
        bus.drive("m2")
    assert str(raised.value) == "there is no can0 drive 'm2'; there are m1"
    with pytest.raises(KeyError) as raised:
        bus.drive("m1").nmt("start")
    assert str(raised.value).startswith("there is no NMT command 'start'")


@pytest.mark.parametrize("data", ["v", "°", 5, None])
def test_ports_take_bytes(kit: Bench, data: Any) -> None:
    for take in (kit.port("m1").write, kit.tap("can0.slcan0").write, lambda data: kit.canbus().send(1, data)):
        with pytest.raises(TypeError) as raised:
            take(data)
        meant = repr(data.encode()) if isinstance(data, str) else "b'...'"
        assert str(raised.value) == f"a port carries bytes: {meant}, not {data!r}"


def test_ports_take_all_that_is_bytes(kit: Bench) -> None:
    for data in (b"", bytearray(), memoryview(b"")):
        kit.port("m1").write(data)


@pytest.mark.parametrize(
    ("ms", "error", "said"),
    [
        ("5", TypeError, "run(ms=...): '5' is text; give a number of milliseconds, as 5"),
        ("soon", TypeError, "run(ms=...): 'soon' is text; give a number of milliseconds, as 100"),
        (None, TypeError, "run(ms=...): None is no number; give a number of milliseconds, as 100"),
        (-5, ValueError, "run(ms=...): -5 is no time from now on; give 0 or more"),
        (float("nan"), ValueError, "run(ms=...): nan is no time from now on; give 0 or more"),
    ],
)
def test_a_time_that_is_none_is_a_sentence(kit: Bench, ms: Any, error: type[Exception], said: str) -> None:
    at_ns = kit.now_ns
    with pytest.raises(error) as raised:
        kit.run(ms)
    assert str(raised.value) == said
    assert _frames(raised) == [Path(__file__).name]
    assert kit.now_ns == at_ns


def test_time_does_not_go_back(kit: Bench) -> None:
    kit.run(ms=1)
    now_ms = kit.now_ns / 1e6
    kit.run_until(now_ms)
    with pytest.raises(
        ValueError, match=r"run_until\(ms=0\): it is .* ms already, and time does not go back;"
    ):
        kit.run_until(0)
    assert kit.now_ns / 1e6 == now_ms


def test_a_capture_into_no_folder_is_a_sentence(kit: Bench, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as raised, kit.capture(tmp_path / "none" / "a.pcapng"):
        pass
    assert str(raised.value) == f"{tmp_path}/none/a.pcapng: there is no folder {tmp_path}/none; make it first"
