"""Segments, checked against the boards' serial interfaces."""

from collections.abc import Collection, Mapping

from hil.config.catalogue import ProfileInfo
from hil.config.document import Finding
from hil.config.explain import shown, suggestion
from hil.vocab.firmware import MAIN, NETWORK


def segment_findings(
    segments: object, devices: Mapping[str, ProfileInfo], real: Collection[str]
) -> list[Finding]:
    """What is wrong with ``segments``; the models tell what has not the form of one. ``devices``: those whose
    profile is known; ``real``: those that are no twins."""
    findings: list[Finding] = []
    taken: dict[tuple[str, str], str] = {}
    for name, segment in segments.items() if isinstance(segments, dict) else ():
        if name in devices:
            message = f"a device has the name {shown(name)} already"
            findings.append(Finding(("segments", name), message, "give the segment another", at_key=True))
        stations = segment.get("stations") if isinstance(segment, dict) else None
        for index, station in enumerate(stations if isinstance(stations, list) else ()):
            if not isinstance(station, str):
                continue
            path = ("segments", name, "stations", index)
            device, dot, uart = station.partition(".")
            uart = uart if dot else NETWORK
            if device not in devices:
                findings.append(
                    Finding(path, f"there is no device {shown(device)}", suggestion(device, devices))
                )
            elif device in real:
                findings.append(Finding(path, f"{device} is a real board", "stations here are twins"))
            elif uart not in (MAIN, NETWORK):
                remedy = suggestion(uart, (MAIN, NETWORK))
                findings.append(Finding(path, f"{device} has no serial interface {shown(uart)}", remedy))
            elif uart == NETWORK and devices[device].network_baud is None:
                message = f"a {devices[device].name} has no network"
                findings.append(Finding(path, message, "leave it out"))
            elif uart == MAIN and devices[device].baud is None:
                message = f"the serial interface of a {devices[device].name} is USB"
                findings.append(Finding(path, message, "leave it out"))
            elif (device, uart) in taken:
                where = taken[device, uart]
                message = f"{device}.{uart} is on segment {where} already"
                findings.append(Finding(path, message, "take one of them out"))
            else:
                taken[device, uart] = name
    return findings
