"""Targets for Prometheus: a file of its file_sd discovery, with an entry for each bench of a lab."""

import json
import re
from collections.abc import Mapping, Sequence
from ipaddress import ip_address
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

from hil.host.new_file import write_file
from hil.host.regular_file import read_text
from hil.wire.json_text import JsonError, read_json

Entry = dict[str, Any]
"""Entry of the file: ``targets``, each as host:port, and ``labels``, with the bench's name as ``bench``."""


class Targets(NamedTuple):
    """Entries of the file, and why benches are not among them, a line each."""

    entries: list[Entry]
    remarks: list[str]


class NoTargets(Exception):
    """Error of a file that is there and is no such file: ``str(error)`` says so."""


def targets(rows: Sequence[Mapping[str, Any]], before: Sequence[Entry], host: str) -> Targets:
    """Make the entries from what benches say. ``before``: those of the file; benches that are
    not there now keep theirs, so that Prometheus sees that they are away. ``host``: this computer's name."""
    found, remarks = list[Entry](), list[str]()
    for row in rows:
        where, why = _metrics_at(row, host)
        if where:
            found.append({"targets": [where], "labels": _labels(row)})
        elif why:
            remarks.append(f"{row['bench']}: {why}")
    there = {entry["labels"]["bench"] for entry in found}
    refused = {remark.partition(":")[0] for remark in remarks}
    found += [entry for entry in before if entry["labels"]["bench"] not in there | refused]
    return Targets(sorted(found, key=lambda entry: (entry["labels"]["bench"], entry["targets"])), remarks)


def _metrics_at(row: Mapping[str, Any], host: str) -> tuple[str, str]:
    """Host and port of a bench's metrics, or why there are none; both empty: it does not say."""
    if "metrics" not in row:
        return "", ""
    if not row["metrics"]:
        return "", "it has no metrics: add `bridges: {metrics: {}}` to its configuration"
    at = urlsplit(row["metrics"])
    name, port = at.hostname or "", at.port or 9464
    try:
        address = ip_address(name)
    except ValueError:
        return f"{name}:{port}", ""
    if address.is_unspecified:
        return f"{row['host']}:{port}", ""
    if address.is_loopback and row["host"] != host:
        return "", f"its metrics are at {name}:{port} of {row['host']} alone: let them `listen:` beyond it"
    return f"[{name}]:{port}" if address.version == 6 else f"{name}:{port}", ""


def _labels(row: Mapping[str, Any]) -> dict[str, str]:
    own = {f"label_{re.sub('[^A-Za-z0-9_]', '_', name)}": value for name, value in row["labels"].items()}
    return {"bench": row["bench"], "host": row["host"], **own}


def read_targets(path: Path) -> list[Entry]:
    """Read the entries of a file; none where there is no file.

    Raises:
        NoTargets: it is another file.
    """
    try:
        entries = read_json(read_text(path))
    except FileNotFoundError:
        return []
    except OSError as error:
        raise NoTargets(f"{path}: {error.strerror}") from None
    except (JsonError, UnicodeDecodeError):
        entries = None
    if not isinstance(entries, list) or not all(map(_is_entry, entries)):
        raise NoTargets(f"{path}: it is there, and no file of targets; choose another name")
    return entries


def _is_entry(entry: object) -> bool:
    match entry:
        case {"targets": list(found), "labels": {"bench": str(_)}}:
            return all(isinstance(each, str) for each in found)
    return False


def write_targets(path: Path, entries: Sequence[Entry]) -> None:
    """Write the file, whole or not at all. Raises OSError: it cannot be written."""
    write_file(path, json.dumps(entries, indent=1).encode() + b"\n")
