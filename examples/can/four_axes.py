"""Home four CANopen drives, then move them in step: a target for each in a PDO, and SYNC for all."""

import sys
import time

import canopen

network = canopen.Network()
network.connect(interface="slcan", channel=sys.argv[1], bitrate=1_000_000)
axes = [network.add_node(number, sys.argv[2]) for number in (1, 2, 3, 4)]
for axis in axes:
    axis.sdo[0x6060].raw, axis.sdo[0x6098].raw = 6, 24  # homing, to the lower edge of the cam
    axis.sdo[0x6099][1].raw, axis.sdo[0x6099][2].raw = 180_000, 18_000  # 0.001 deg/s
    for word in (0x06, 0x07, 0x0F, 0x1F):  # shutdown, switch on, enable, start
        axis.sdo[0x6040].raw = word
while not all(axis.sdo[0x6041].raw & 0x1400 == 0x1400 for axis in axes):
    time.sleep(0.05)
for axis in axes:
    for pdo, mapped in ((axis.rpdo[1], (0x6040, 0x607A)), (axis.tpdo[1], (0x6041, 0x6064))):
        pdo.read()
        pdo.clear()
        pdo.map = [pdo.add_variable(index) for index in mapped]
        pdo.trans_type, pdo.enabled = 1, True
        pdo.save()
    axis.sdo[0x60C2][1].raw, axis.sdo[0x60C2][2].raw = 100, -3  # a target each 100 ms
    axis.sdo[0x6060].raw, axis.rpdo[1][0x6040].raw = 8, 0x0F  # cyclic position
network.nmt.state = "OPERATIONAL"
apart = []
for target in [*range(0, 90_001, 3000), *[90_000] * 5]:
    for axis in axes:
        axis.rpdo[1][0x607A].raw = target
        axis.rpdo[1].transmit()
    network.sync.transmit()
    time.sleep(0.1)
    at = [axis.tpdo[1][0x6064].raw / 1000 for axis in axes]
    apart.append(max(at) - min(at))
print("they stand at", *(f"{position:.1f}" for position in at))
print(f"{len(apart)} SYNCs, never more than {max(apart):.2f} deg apart")
network.disconnect()
