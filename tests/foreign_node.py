#!/usr/bin/env python3
"""A node of a SAC network that knows nothing of this project: the bytes of a tty, the standard library.

foreign_node.py TTY master DESTINATION DATA   send a packet, say how it was answered ("!m3": spoilt CRC)
foreign_node.py TTY node ID SECONDS           answer packets, and text with text, for so long
"""

import os
import select
import sys
import time
import tty

STX, ETX, ACK, NAK, SIGNALS = b"\2", b"\3", b"\6", b"\x15", (b"\6", b"\x15", b"\x11", b"\x12")


def check(data):
    value = 0
    for bit in (byte >> place & 1 for byte in data for place in range(8)):
        value = value >> 1 ^ (0x8C if (value ^ bit) & 1 else 0)
    return value


def packet(to, own, data, spoil=0):
    return STX + bytes((to, own)) + data + ETX + bytes((check(data) ^ spoil, 0))


def packets(fd, seconds):
    """(to, from, data, whether the CRC is right) as they come."""
    held, end = b"", time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        if select.select([fd], [], [], left)[0]:
            held += os.read(fd, 4096)
        while (start := held.find(STX)) >= 0 and (stop := held.find(ETX, start + 3)) >= 0:
            size = stop + (2 if held[stop + 1 : stop + 2] == b"\0" else 3)  # NUL, or a CRC and NUL
            if len(held) < size:
                break
            data, crc = held[start + 3 : stop], held[stop + 1]
            yield held[start + 1], held[start + 2], data, crc in (0, check(data))
            held = held[size:]


def main(path, role, address, last):
    fd = os.open(path, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(fd)
    if role == "master":
        os.write(fd, packet(int(address), 1, last.removeprefix("!").encode(), 64 * last.startswith("!")))
        for to, origin, answer, right in packets(fd, 5):
            print(to, origin, {ACK: "ACK", NAK: "NAK"}.get(answer, answer), right)
            return 0
        return 1
    print("ready", flush=True)
    for to, origin, data, right in packets(fd, float(last)):
        print(to, origin, data, right, flush=True)
        if to == int(address) and data not in SIGNALS:
            os.write(fd, packet(origin, to, ACK if right else NAK))
            if right and data[:1] in b" .":
                os.write(fd, packet(origin, to, b" you said" + data))
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
