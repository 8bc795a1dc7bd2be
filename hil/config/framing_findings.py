"""Checks of what lines speak: all on one segment the same, and faults that its packets can have."""

from collections.abc import Iterator, Mapping
from typing import Any

from hil.config.catalogue import Catalogue, ProfileInfo
from hil.config.document import Finding, KeyPath
from hil.config.explain import shown, suggestion
from hil.config.station_names import node_addresses, station_addresses
from hil.vocab.address import Address, owner_of
from hil.vocab.faults import OF_FRAMINGS
from hil.vocab.framing import Framing
from hil.vocab.line_format import EIGHT_N_1

_NO_PACKETS = "say at a tap what the packets on this line are, as in `framing: sac`"
Said = tuple[KeyPath, str, str]
"""Statement of what a line speaks: where it is said, who says so, and the framing's name."""


def framing_findings(
    value: Mapping[str, Any], devices: Mapping[str, ProfileInfo], catalogue: Catalogue
) -> Iterator[Finding]:
    """Findings about what segments speak. ``devices``: those whose profile is known."""
    lines: dict[str, Framing] = {}
    segments = value.get("segments")
    for name, segment in segments.items() if isinstance(segments, dict) else ():
        if not isinstance(segment, dict):
            continue
        yield from _format(name, segment, devices)
        said = [
            *_boards(name, segment, devices, catalogue),
            *_nodes(name, segment, devices, catalogue),
            *_taps(name, segment),
        ]
        known = [each for each in said if each[2] in catalogue.framings]
        for path, _, framing in said:
            if framing not in catalogue.framings:
                remedy = suggestion(framing, catalogue.framings)
                yield Finding(path, f"there is no framing {shown(framing)}", remedy)
        for path, _, framing in known[1:]:
            if framing != known[0][2]:
                message = f"{name} speaks {known[0][2]} already, by {known[0][1]}; this is {framing}"
                yield Finding(path, message, "put it on a segment of its own")
        if known or not said:
            framing_here = catalogue.framings[known[0][2]] if known else _of_bytes()
            lines |= dict.fromkeys((name, *_stations(name, segment, devices, catalogue)), framing_here)
    yield from _faults(value.get("faults"), lines)


def _format(name: str, segment: Mapping[str, Any], devices: Mapping[str, ProfileInfo]) -> Iterator[Finding]:
    of_8n1 = _without_program(segment, devices)
    if segment.get("format", EIGHT_N_1.name) != EIGHT_N_1.name and of_8n1:
        message = f"{of_8n1[0]} speaks {EIGHT_N_1.name}, as all boards' UARTs do but a processor's"
        remedy = "put it on a segment of its own, or leave format out"
        yield Finding(("segments", name, "format"), message, remedy)


def _without_program(segment: Mapping[str, Any], devices: Mapping[str, ProfileInfo]) -> list[str]:
    """Stations of a segment whose format no program of a user sets."""
    stations = segment.get("stations")
    names = [str(each) for each in stations] if isinstance(stations, list) else []
    return [each for each in names if (of := devices.get(owner_of(each))) is None or of.processor is None]


def _of_bytes() -> Framing:
    """Framing of a line on which nothing says what it speaks."""
    from hil.wire.bytes_framing import BYTES  # most benches have no such line

    return BYTES


def _boards(
    name: str, segment: Mapping[str, Any], devices: Mapping[str, ProfileInfo], catalogue: Catalogue
) -> Iterator[Said]:
    stations = segment.get("stations")
    for index, station in enumerate(stations if isinstance(stations, list) else ()):
        device = owner_of(str(station))
        if device not in devices or catalogue.problems(profile := devices[device].name):
            continue
        if framing := catalogue.boards[profile].framing:
            yield ("segments", name, "stations", index), device, framing.name


def _nodes(
    name: str, segment: Mapping[str, Any], devices: Mapping[str, ProfileInfo], catalogue: Catalogue
) -> Iterator[Said]:
    """Framings that nodes and a format say; of a format that boards cannot have, ``_format`` tells."""
    is_other = segment.get("format", EIGHT_N_1.name) != EIGHT_N_1.name
    is_other = is_other and not _without_program(segment, devices)
    for kind in catalogue.node_kinds:
        if isinstance(segment.get(kind.key), dict):
            yield ("segments", name, kind.key), kind.key, kind.framing(EIGHT_N_1).name
        elif is_other and kind.has_other_formats:
            yield ("segments", name, "format"), "format", kind.framing(EIGHT_N_1).name


def _taps(name: str, segment: Mapping[str, Any]) -> Iterator[Said]:
    taps = segment.get("taps")
    for tap, keys in taps.items() if isinstance(taps, dict) else ():
        if isinstance(keys, dict) and isinstance(keys.get("framing"), str):
            yield ("segments", name, "taps", tap, "framing"), tap, keys["framing"]


def _stations(
    name: str, segment: Mapping[str, Any], devices: Mapping[str, ProfileInfo], catalogue: Catalogue
) -> Iterator[str]:
    stations, taps = segment.get("stations"), segment.get("taps")
    for station in stations if isinstance(stations, list) else ():
        yield from station_addresses(str(station), devices)
    for kind in catalogue.node_kinds:
        yield from node_addresses(kind, segment, devices)
    yield from (str(Address(name, str(tap))) for tap in (taps if isinstance(taps, dict) else ()))


def _faults(entries: object, lines: Mapping[str, Framing]) -> Iterator[Finding]:
    for index, entry in enumerate(entries if isinstance(entries, list) else ()):
        if not isinstance(entry, dict):
            continue
        kind, framing = entry.get("fault"), lines.get(str(entry.get("target")))
        if framing and isinstance(kind, str) and kind in OF_FRAMINGS and kind not in framing.faults:
            able = ", ".join(framing.faults)
            remedy = f"of faults of packets it can have {able}" if able else _NO_PACKETS
            message = f"{kind} means nothing on a line of {framing.name}"
            yield Finding(("faults", index, "fault"), message, remedy)
