"""Handler of pyserial for URLs of ports: ``hil://m1``, and ``hil://BENCH/m1``.

In a test that is a port of the newest bench that has it, those in memory first; outside, of a bench that `hil
serve` runs on this computer. ``import hil.testing`` registers it; in a program that is not to import hil,
``serial.protocol_handler_packages.append("hil.testing.serial_ports")`` does.
"""

import os
from collections.abc import Callable, Iterator, Mapping
from itertools import chain
from typing import Any

import serial

from hil.net.benches_here import find
from hil.net.control_client import BenchSilent, ControlError, ask
from hil.testing.serial_ports.open_benches import LIVE, open_benches
from hil.vocab.near_words import meant

_SCHEME = "hil://"
_HOW = (
    "make a bench in the test (hil.testing.Bench, or the fixture bench), run the program in one"
    " (hil virtual BENCH.yaml PROGRAM), or start one (hil serve BENCH.yaml)"
)
Make = Callable[..., serial.SerialBase]


def serial_class_for_url(url: str) -> tuple[str, Make]:
    """Find the port that a URL means: the name or address by which pyserial opens it, and what makes its
    ``Serial``.

    Raises:
        ValueError: it is no URL of a port.
        serial.SerialException: there is no such port, with how to get one.
    """
    bench, name = _parts(url)
    known = list[str]()
    for ports in open_benches():
        if bench in (None, ports.bench):
            if name in ports.terminals:
                return name, ports.maker(name)
            known += ports.terminals
    told = list[str]()
    live = (ports for name, ports in reversed(LIVE) if bench in (None, name))
    for address_of in chain(live, _served(bench, told)):
        if name in address_of:
            return address_of[name], _opener(address_of[name])
        known += address_of
    said = meant(name, dict.fromkeys(known)) if known else "no bench has one now"
    raise serial.SerialException("; ".join([f"there is no port {url}: {said}", *told, _HOW]))


def _parts(url: str) -> tuple[str | None, str]:
    *benches, name = url[len(_SCHEME) :].rstrip("/").split("/")
    if not name or len(benches) > 1 or not all(benches):
        raise ValueError(f"{url} names no port: write {_SCHEME}PORT, or {_SCHEME}BENCH/PORT")
    return benches[0] if benches else None, name


def _served(bench: str | None, told: list[str]) -> Iterator[Mapping[str, str]]:
    """Addresses of the ports of each bench that is served here, by name; ``told``: gets what is wrong."""
    for here in find(None, os.environ).running().meant(bench or os.environ.get("HIL_BENCH") or None):
        try:
            listed = ask(here.socket, "list")
        except (BenchSilent, ControlError) as error:
            told.append(str(error))
            continue
        found: dict[str, str | None] = {tap["tap"]: tap["port"] for tap in listed["taps"]}
        for row in listed["devices"]:
            found[row["device"]] = row["address"]
            found |= {name: port["address"] for name, port in row["ports"].items()}
        yield {name: address for name, address in found.items() if address}


def _opener(address: str) -> Make:
    def make(_: None, *given: Any, **options: Any) -> serial.SerialBase:
        return serial.serial_for_url(address, *given, do_not_open=True, **options)

    return make
