"""A table of points as a PLC goes through it: the set-point into registers, the start bit, until it is done.

``hil serve examples/modbus/bench.yaml`` has the drive; where its registers are says ``lathe.yaml``.
"""

import sys
import time

from pymodbus.client import ModbusTcpClient

POSITION, STATUS, SET_POINT, CONTROL = 0, 4, 10, 20
ENABLE, START, MOVING = 1, 2, 2
RPM_PER_S = 3000
POINTS = ((90.0, 60), (-45.5, 120), (720.0, 600), (0.0, 600))
INT32 = ModbusTcpClient.DATATYPE.INT32


def go(plc: ModbusTcpClient, position_deg: float, rpm: int) -> float:
    words = plc.convert_to_registers(round(position_deg * 100), INT32, word_order="little")
    plc.write_registers(SET_POINT, [*words, rpm, RPM_PER_S])
    plc.write_register(CONTROL, ENABLE | START)
    while plc.read_input_registers(STATUS, count=1).registers[0] & MOVING:
        time.sleep(0.01)
    plc.write_register(CONTROL, ENABLE)  # the start bit has to become 1 again
    time.sleep(0.1)  # the shaft is behind its set-point: a moment to settle
    words = plc.read_input_registers(POSITION, count=2).registers
    return plc.convert_from_registers(words, INT32, word_order="little") / 100


with ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]) if sys.argv[1:] else 1502) as plc:
    plc.write_register(CONTROL, ENABLE)
    for number, (position_deg, rpm) in enumerate(POINTS, 1):
        stands_at = go(plc, position_deg, rpm)
        print(f"point {number}: {position_deg:7.2f} deg at {rpm:3} rpm, stands at {stands_at:7.2f}")
    refused = plc.write_register(SET_POINT + 2, 0)
    print(f"a speed of 0 is refused with exception {refused.exception_code:02}")
    plc.write_register(CONTROL, 0)
