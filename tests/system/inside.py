"""A client of a serial port, in the container: inside.py URL.

Lines of JSON, [send, await], are answered with what came; it ends with them.
An error of the port is the answer ``{"error": ...}``.
"""

import json
import sys
import time

import serial

PATIENCE_S = 20


def main(url: str) -> None:
    try:
        port = serial.serial_for_url(url, 38400, timeout=0.05)
    except OSError as error:
        print(json.dumps({"error": str(error)}), flush=True)
        return
    print(json.dumps("open"), flush=True)
    for line in sys.stdin:
        sent, awaited = (text.encode("latin-1") for text in json.loads(line))
        port.write(sent)
        got, deadline = b"", time.monotonic() + PATIENCE_S
        while awaited not in got and time.monotonic() < deadline:
            got += port.read(max(port.in_waiting, 1))
        print(json.dumps(got.decode("latin-1")), flush=True)


main(sys.argv[1])
