"""A bus master as somebody might write it: pyserial, and nothing of hil. Tells each node a command, and tries
again when the answer is missing or wrong.

    python master.py PORT COMMAND FIRST LAST
"""

import sys

import serial

STX, ETX, ACK, NAK = 2, 3, 6, 21
TRIES = 3


def crc8(data: bytes) -> int:
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x8C if crc & 1 else 0)
    return crc


def packet(node: int, data: bytes) -> bytes:
    return bytes((STX, node, 1)) + data + bytes((ETX, crc8(data), 0))


def answer(line: serial.Serial, node: int) -> str:
    heard = line.read(6)
    if heard[5:] != b"\0":  # NUL in the CRC's place ends a packet that has none ($H0)
        heard += line.read(1)
        if len(heard) < 7:
            return "silence" if not heard else "cut off"
    if heard[0] != STX or heard[1:3] != bytes((1, node)) or heard[4] != ETX:
        return "garbled"
    if heard[5] not in (0, crc8(heard[3:4])):
        return "garbled"
    return {ACK: "ACK", NAK: "NAK"}.get(heard[3], "nonsense")


def main(port: str, command: str, first: str, last: str) -> int:
    lost = 0
    with serial.Serial(port, 38400, timeout=0.5) as line:  # a busy computer may answer late
        for node in range(int(first), int(last) + 1):
            said = []
            while len(said) < TRIES and said[-1:] != ["ACK"]:
                line.reset_input_buffer()
                line.write(packet(node, command.encode()))
                said.append(answer(line, node))
            if said != ["ACK"]:
                print(f"node {node}: {', '.join(said)}")
            lost += said[-1] != "ACK"
    print(f"{int(last) - int(first) + 1 - lost} nodes have it, {lost} have not")
    return lost > 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
