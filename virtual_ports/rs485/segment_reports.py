"""Reports on segments: state and statistics, problems, metrics, tables of ``hil status``."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hil.vocab.monitoring import HealthProblem
from hil.vocab.wire import Report, WireInfo, WireTap, WireView, counted, errors_of, one_of

if TYPE_CHECKING:
    from hil.vocab.segment import SegmentView


def segment_report(
    name: str, segment: "SegmentView", elapsed_ns: int, taps: Sequence[WireTap], cards: Mapping[str, Any]
) -> Report:
    """Report on a segment with its stations, taps, nodes and counters."""
    from hil.vocab.segment import speed_notes

    clashes = [f"address {address}: {', '.join(who)}" for address, who in segment.clashes().items()]
    notes = [f"two stations have one {clash}" for clash in clashes]
    unheard = {each.label: each.tap.baud for each in taps if not each.clients}
    notes += speed_notes(dict(segment.speeds()) | unheard)
    for each in taps:
        notes += [each.failure] if each.failure else []
        notes += each.tap.notes.values()
    row = {
        "segment": name,
        "taps": [each.row() | {"baud": each.tap.baud} for each in taps],
        "nodes": {name: card.counters() for name, card in cards.items()},
        "notes": notes,
        "framing": segment.framing.name,
    }
    return row | segment.counters(elapsed_ns)


def segment_problems(name: str, segment: "SegmentView", taps: Sequence[WireTap]) -> Iterator[HealthProblem]:
    """Problems of addresses and speeds; what clients of taps have set is theirs."""
    from hil.vocab.segment import speed_notes

    for address, stations in segment.clashes().items():
        what = f"two stations have one address {address}: {', '.join(stations)}"
        yield HealthProblem("segment", name, what, "give each an address of its own")
    own = {each.label: each.tap.baud for each in taps}
    for what in speed_notes(dict(segment.speeds()) | own):
        yield HealthProblem("segment", name, what, "give all one `baud`, those of devices and the segment's")


def _tables(reports: Sequence[Report]) -> Iterable[WireView]:
    columns = ("segment", "stations", "load", "packets", "collisions", "errors")
    rows = [
        (each["segment"], str(len(each["stations"])), f"{each['load']:.1%}", str(each["packets"]),
         str(each["collisions"]), counted(each["errors"]))
        for each in reports
    ]  # fmt: skip
    yield WireView(columns, ("segment", "errors"), rows)
    if nodes := {name: node for each in reports for name, node in each["nodes"].items()}:
        counts = ("unit", "requests", "answers", "exceptions")
        cells = [
            (name, *(str(node[kind]) for kind in counts), node["refusal"] or "")
            for name, node in nodes.items()
        ]
        yield WireView(("node", *counts, "last refusal"), ("node", "last refusal"), cells)


REPORTS = WireInfo("segments", "segment", _tables, (
    one_of("hil_segment_packets_total", "counter", "packets", "segment", lambda told: told["packets"]),
    one_of("hil_segment_bytes_total", "counter", "bytes", "segment", lambda told: told["bytes"]),
    one_of("hil_segment_collisions_total", "counter", "drivers that came on beside another", "segment",
           lambda told: told["collisions"]),
    errors_of("hil_segment_errors_total", "what was wrong with packets", "segment"),
    one_of("hil_segment_load_ratio", "gauge", "share of the time that the line was busy", "segment",
           lambda told: told["load"]),
))  # fmt: skip
