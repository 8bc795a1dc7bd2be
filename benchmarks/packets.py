"""Speed of the packet codec: packets made and read a second, at least 500,000 of which are wanted.

Reads them in pieces of 4096 bytes and one by one, each checked. The reference, to tell this machine's speed,
is binascii.crc32 over the same data, one call a packet.
"""

import binascii
import statistics
import sys
import time
from collections.abc import Callable

from device_profiles.sac.packet import PacketDecoder, encode

PACKETS = 20_000 if "--quick" in sys.argv else 200_000
RUNS = 5
DATA = b"m3000v150"
ONE = encode(85, 1, DATA)
STREAM = ONE * PACKETS


def made() -> int:
    return sum(len(encode(85, 1, DATA)) > 0 for _ in range(PACKETS))


def read_in_pieces() -> int:
    decoder = PacketDecoder()
    return sum(
        packet.is_good  # type: ignore[union-attr]
        for at in range(0, len(STREAM), 4096)
        for packet in decoder.feed(STREAM[at : at + 4096])
    )


def read_one_by_one() -> int:
    decoder = PacketDecoder()
    return sum(len(decoder.feed(ONE)) for _ in range(PACKETS))


def reference() -> int:
    return sum(binascii.crc32(DATA) > 0 for _ in range(PACKETS))


def main() -> None:
    kinds: dict[str, Callable[[], int]] = {
        "made": made,
        "read in pieces": read_in_pieces,
        "read one by one": read_one_by_one,
        "reference": reference,
    }
    rates: dict[str, list[float]] = {name: [] for name in kinds}
    for _ in range(RUNS):
        for name, run in kinds.items():
            start = time.perf_counter()
            assert run() == PACKETS
            rates[name].append(PACKETS / (time.perf_counter() - start))
    for name, found in rates.items():
        print(f"{name:16} {statistics.median(found):12,.0f} a second")


main()
