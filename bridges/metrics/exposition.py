"""The text exposition format 0.0.4 of Prometheus, line by line. Pure.

Source: prometheus.io, "Exposition formats".
"""

from collections.abc import Iterable, Iterator

from hil.vocab.metrics import Histogram, Metric, Reading, Value

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"


def lines(readings: Iterable[Reading]) -> Iterator[str]:
    """Format each metric's help and type, then its values, as they are asked for."""
    for metric, values in readings:
        yield f"# HELP {metric.name} {_help(metric.about)}\n# TYPE {metric.name} {metric.kind}\n"
        for labels, value in values:
            yield _sample(metric, labels, value)


def _sample(metric: Metric, labels: tuple[str, ...], value: Value) -> str:
    named = [f'{name}="{_escaped(label)}"' for name, label in zip(metric.labels, labels, strict=True)]
    if not isinstance(value, Histogram):
        return f"{metric.name}{_braces(named)} {_number(value)}\n"
    text, below = "", 0
    for bound_s, count in value.buckets:
        below += count
        text += f"{metric.name}_bucket{_bucket(named, _number(bound_s))} {below}\n"
    total = below + value.over
    text += f"{metric.name}_bucket{_bucket(named, '+Inf')} {total}\n"
    own = _braces(named)
    return f"{text}{metric.name}_sum{own} {_number(value.total_s)}\n{metric.name}_count{own} {total}\n"


def _braces(named: list[str]) -> str:
    return "{" + ",".join(named) + "}" if named else ""


def _bucket(named: list[str], bound: str) -> str:
    return _braces([*named, f'le="{bound}"'])


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else repr(float(value))


def _escaped(label: str) -> str:
    return label.replace("\\", r"\\").replace('"', r"\"").replace("\n", r"\n")


def _help(text: str) -> str:
    return text.replace("\\", r"\\").replace("\n", r"\n")
