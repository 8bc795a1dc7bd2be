"""Sixteen axes sent somewhere and polled over Modbus TCP, with pymodbus.

First `hil serve examples/modbus/poll16.yaml`; `python poll16.py 1503` for another port than 1502.
"""

import struct
import sys
import time

from pymodbus.client import ModbusTcpClient

UNITS = range(1, 17)
COMMAND, MOVE_ABS = 11, 2
ON, MOVING, BUSY = 0, 1, 5


def poll(plc: ModbusTcpClient, unit: int) -> tuple[list[bool], float, float]:
    """Bits of the status word, position and set-point of an axis."""
    words = plc.read_input_registers(6, count=10, device_id=unit).registers  # all of one moment
    position, set_point = struct.unpack(">i12xi", struct.pack(">10H", *words))
    return plc.read_discrete_inputs(200, count=7, device_id=unit).bits, position / 1000, set_point / 1000


with ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]) if len(sys.argv) > 1 else 1502) as plc:
    for unit in UNITS:  # one write: 1 + the verb's number, and its parameter
        target = struct.unpack(">2H", struct.pack(">f", 22.5 * unit))
        while plc.write_registers(COMMAND, [1 + MOVE_ABS, *target], device_id=unit).isError():
            time.sleep(0.1)  # a board that starts answers with exception 06
    while any(poll(plc, unit)[0][BUSY] for unit in UNITS):
        time.sleep(0.05)
    print("unit  on   moving  set-point  position")
    for unit in UNITS:
        status, position_deg, set_point_deg = poll(plc, unit)
        on, moving = (("no", "yes")[status[bit]] for bit in (ON, MOVING))
        print(f"{unit:4}  {on:3}  {moving:6} {set_point_deg:10.3f} {position_deg:9.3f}")
