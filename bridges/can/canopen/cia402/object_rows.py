"""Rows for people: the objects of a drive, its error codes and its homing methods, as Markdown."""

from collections.abc import Iterator

from bridges.can.canopen.cia402.error_codes import ABOUT
from bridges.can.canopen.cia402.objects import MODES, NAMES, PATHS, ROWS, TORQUE
from bridges.can.canopen.node.application import Access, Entry
from hil.firmware.homing_methods import METHODS, HomingMethod

_NEEDS = {"": "", PATHS: "boards that follow paths", TORQUE: "boards with `torque`"}
_WAYS = {-1: "negative", 1: "positive"}


def object_rows() -> Iterator[str]:
    """Tell the objects, in the order of their indices."""
    yield "| object | name | type | access | default | limits | PDO | what it is | of |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for row in sorted(ROWS, key=lambda row: (row.entry.index, row.entry.subindex)):
        entry = row.entry
        if entry.subindex == 0 and entry.index in NAMES:
            continue  # it only counts the others
        place = f"{entry.index:04X}h" + (f":{entry.subindex}" if entry.index in NAMES else "")
        name = f"{NAMES[entry.index]}: {entry.name}" if entry.index in NAMES else entry.name
        default = "" if entry.is_live else str(entry.default)
        if entry.access is Access.CONST and not entry.default:
            default = "the board's"
        about = entry.about + (" Kept by 1010h." if entry.is_stored else "")
        kind = entry.data_type.name
        cells = (f"`{place}`", name, kind, entry.access, default, _limits(entry), entry.mapping, about)
        yield f"| {' | '.join(cells)} | {_NEEDS[row.needs]} |"


def mode_rows() -> Iterator[str]:
    """Tell the modes of operation."""
    yield "| mode | what it is |"
    yield "|---|---|"
    for number, about in MODES.items():
        yield f"| {number} | {about} |"


def error_rows() -> Iterator[str]:
    """Tell the error codes."""
    yield "| code | meaning |"
    yield "|---|---|"
    for code, about in ABOUT.items():
        yield f"| `{code:04X}h` | {about} |"


def homing_rows() -> Iterator[str]:
    """Tell the homing methods."""
    yield "| method | home | first | finally | needs |"
    yield "|---|---|---|---|---|"
    for number, method in sorted(METHODS.items()):
        yield f"| {number} | {' | '.join(_homing_cells(method))} |"


def _homing_cells(method: HomingMethod) -> tuple[str, str, str, str]:
    needs = ", ".join([*method.needs(), *(["index"] if method.by_index else [])]) or "-"
    if not method.switch and not method.by_index:
        return "the present position", "-", "-", needs
    last = _WAYS[method.to_edge]
    if not method.switch:
        return "the next index", "-", last, needs
    edge = f"where the `{method.switch}` switch {'becomes active' if method.is_onto else 'is left'}"
    home = f"the next index from {edge}" if method.by_index else edge
    turns = ", back at a limit switch" if method.turns_back else ""
    return home, _WAYS[method.first] + turns, last, needs


def _limits(entry: Entry) -> str:
    if entry.low is None and entry.high is None:
        return ""
    low = "" if entry.low is None else str(entry.low)
    return f"{low} to {entry.high}" if entry.high is not None else f"from {low}"


def reference() -> str:
    """Section of the reference on objects of drives, Markdown."""
    parts = [
        "## Objects of CANopen drives\n",
        "Of CiA 402, from the table that the data sheets are made of; objects below 2000h are those of"
        " CiA 301. What the units are and what the standard leaves open is in"
        " [decision 0029](decisions/0029-drives-of-cia-402.md).\n",
        *object_rows(),
        "\n### Modes of operation\n",
        *mode_rows(),
        "\n### Homing methods\n",
        *homing_rows(),
        "\n### Error codes of drives\n",
        "In 603Fh and in EMCY; a board's own faults have codes of CiA 402.\n",
        *error_rows(),
    ]
    return "\n".join(parts)
