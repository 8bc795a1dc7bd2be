"""Program in the guest: has a SAC save a parameter in its EEPROM, again and again, and tells what was
acknowledged.

Lines: ``base N``, how many commits there were before the first one; then ``ack N`` after each answer of
the board. The N-th save stores an acceleration of 1.00 + (N mod 900) / 100.
"""

import sys
import time

import serial

from hil.firmware.nvm import decode

STATE = "/var/lib/private/hil/lab/s1.nvm"


def ask(port: serial.Serial, sent: bytes, awaited: bytes = b"SAC>") -> bytes:
    port.write(sent)
    got, deadline = b"", time.monotonic() + 60
    while awaited not in got:
        got += port.read(max(port.in_waiting, 1))
        if time.monotonic() > deadline:
            raise SystemExit(f"no {awaited!r} in {got!r}")
    return got


def main(first: int, saves: int) -> None:
    with serial.serial_for_url("/run/hil/lab/s1", 38400, timeout=0.05) as port:
        ask(port, b"\r")
        for n in range(first, first + saves):
            ask(port, b"$Cd%d.%02d\r" % divmod(100 + n % 900, 100))
            if n == first:
                with open(STATE, "rb") as file:
                    print(f"base {decode(file.read()).content.counter - n}", flush=True)
            print(f"ack {n}", flush=True)


main(*map(int, sys.argv[1:]))
