"""LSS in words: how a master finds nodes and gives them their id and bit rate.

Source: CiA 305, chapter 6.
"""

_BIT_RATES = (1000, 800, 500, 250, 125, None, 50, 20, 10)
"""kbit/s by the index of the first table."""
_IDENTITY = ("vendor-id", "product code", "revision number", "serial number")
_MODES = ("waiting", "configuration")
_ANSWERS = ("done", "refused")


def lss_request(data: bytes) -> str:
    """Say a frame of the master."""
    if len(data) != 8:
        return f"{len(data)} bytes, an LSS frame has 8"
    command, number = data[0], int.from_bytes(data[1:5], "little")
    if command == 0x04:
        return f"all: {_MODES[data[1]] if data[1] < 2 else f'unknown mode {data[1]}'}"
    if 0x40 <= command <= 0x43:
        return f"select by {_IDENTITY[command - 0x40]} {number:08X}h"
    if 0x46 <= command <= 0x4B:
        bounds = [f"{end} {name}" for name in _IDENTITY[2:] for end in ("lowest", "highest")]
        names = (*_IDENTITY[:2], *bounds)
        return f"who has {names[command - 0x46]} {number:08X}h"
    if command == 0x11:
        return f"set the node id to {data[1]}" if data[1] != 0xFF else "take the node id away"
    if command == 0x13:
        return f"set the bit rate to {_bit_rate(data[1], data[2])}"
    if command == 0x15:
        return f"switch to the new bit rate, {int.from_bytes(data[1:3], 'little')} ms before and behind"
    if 0x5A <= command <= 0x5D:
        return f"what is your {_IDENTITY[command - 0x5A]}"
    if command == 0x51:
        return _fastscan(data, number)
    plain = {0x17: "keep the configuration", 0x4C: "who has no node id yet", 0x5E: "what is your node id"}
    return plain.get(command, f"unknown command {command:02X}h")


def lss_response(data: bytes) -> str:
    """Say a frame of a node."""
    if len(data) != 8:
        return f"{len(data)} bytes, an LSS frame has 8"
    command, number = data[0], int.from_bytes(data[1:5], "little")
    if command in (0x11, 0x13, 0x17):
        what = {0x11: "node id", 0x13: "bit rate", 0x17: "keep"}[command]
        return f"{what}: {_ANSWERS[data[1] > 0]}{f', reason {data[1]}.{data[2]}' if data[1] else ''}"
    if 0x5A <= command <= 0x5D:
        return f"{_IDENTITY[command - 0x5A]} {number:08X}h"
    if command == 0x5E:
        return "no node id" if data[1] == 0xFF else f"node id {data[1]}"
    plain = {0x44: "selected", 0x4F: "here is such a node", 0x50: "here is one without a node id"}
    return plain.get(command, f"unknown answer {command:02X}h")


def _fastscan(data: bytes, number: int) -> str:
    bit, at, following = data[5:8]
    if bit == 0x80:
        return "fastscan: who has no node id yet"
    if at > 3 or bit > 31:
        return "fastscan of what cannot be"
    wanted = f"{number:08X}h from bit {bit} on" if bit else f"{number:08X}h"
    then = "" if bit or following == at else f", then {_IDENTITY[following & 3]}"
    return f"fastscan: whose {_IDENTITY[at]} is {wanted}{then}"


def _bit_rate(table: int, index: int) -> str:
    rate = _BIT_RATES[index] if table == 0 and index < len(_BIT_RATES) else None
    if rate:
        return f"{rate} kbit/s"
    return "what is found" if table == 0 and index == 9 else f"number {index} of table {table}"
