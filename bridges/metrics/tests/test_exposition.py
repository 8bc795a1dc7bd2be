"""Output of the metrics bridge, read by Prometheus' own parser."""

from collections.abc import Iterator

from prometheus_client.parser import text_string_to_metric_families

from bridges.metrics.metrics_bridge import lines
from hil.vocab.monitoring import Histogram, Metric, Reading


def families(*readings: Reading) -> dict[str, list[tuple[str, dict[str, str], float]]]:
    parsed = text_string_to_metric_families("".join(lines(readings)))
    return {each.name: [(s.name, s.labels, s.value) for s in each.samples] for each in parsed}


def test_counters_and_gauges() -> None:
    bytes_, load = Metric("x_bytes_total", "counter", "bytes", ("port",)), Metric("x_load", "gauge", "load")
    found = families((bytes_, [(("m1",), 12), (("m2",), 2**60)]), (load, [((), 0.125)]))
    assert found == {
        "x_bytes": [("x_bytes_total", {"port": "m1"}, 12), ("x_bytes_total", {"port": "m2"}, 2**60)],
        "x_load": [("x_load", {}, 0.125)],
    }


def test_labels_and_help_may_have_any_character() -> None:
    label = 'a "quoted" \\ path\nand {another}, é'
    metric = Metric("x", "gauge", "a \\ and\na line", ("what",))
    text = "".join(lines([(metric, [((label,), 1)])]))
    (family,) = text_string_to_metric_families(text)
    assert family.documentation == "a \\ and\na line"
    assert family.samples[0].labels == {"what": label}


def test_a_histogram_is_cumulative() -> None:
    metric = Metric("x_seconds", "histogram", "lag", ("of",))
    found = families((metric, [(("a",), Histogram([(0.5, 3), (1.0, 0), (2.0, 4)], 1, 9.25))]))
    buckets = [
        (labels["le"], value) for name, labels, value in found["x_seconds"] if name.endswith("_bucket")
    ]
    assert buckets == [("0.5", 3), ("1.0", 3), ("2.0", 7), ("+Inf", 8)]
    assert {(name, value) for name, _, value in found["x_seconds"]} >= {
        ("x_seconds_sum", 9.25),
        ("x_seconds_count", 8),
    }


def test_values_are_read_when_they_are_written() -> None:
    read: list[str] = []

    def values(name: str) -> Iterator[tuple[tuple[str, ...], float]]:
        read.append(name)
        yield (), 1

    written = lines([(Metric(name, "gauge", name), values(name)) for name in ("a", "b")])
    assert next(written).startswith("# HELP a a\n")
    assert read == []
    assert next(written) == "a 1\n"
    assert read == ["a"]
