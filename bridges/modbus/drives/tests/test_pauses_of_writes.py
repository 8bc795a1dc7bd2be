"""Silence behind an answer, also between writes that are asked for together."""

import asyncio

from foreign_drives import HostileDrive, Registers, framed

from bridges.modbus.drives.control_bits import RegisterWrite
from bridges.modbus.drives.modbus_client import ModbusClient
from bridges.modbus.drives.modbus_drive_address import TcpPlace
from bridges.modbus.protocol.pdu import Table

PAUSE_S = 0.03


def test_each_of_several_writes_waits_for_the_pause_behind_the_answer_before() -> None:
    answered_s: list[float] = []
    pauses_s: list[float] = []
    registers = Registers()

    async def answer(request: bytes, writer: asyncio.StreamWriter) -> None:
        now_s = asyncio.get_running_loop().time()
        pauses_s.extend(now_s - before_s for before_s in answered_s[-1:])
        if request[7] == 6:
            writer.write(framed(request, bytes([0x86, 1])))
        else:
            writer.write(framed(request, registers.pdu(request)))
        answered_s.append(now_s)

    async def doing() -> None:
        hostile = HostileDrive(answer)
        client = ModbusClient(TcpPlace("127.0.0.1", await hostile.listen()), 2.0, lambda: None)
        client.pause_s = PAUSE_S
        await client.open()
        for address, word in ((1, 7), (2, 8)):  # the first one finds that 06 is missing
            await client.write(1, RegisterWrite(Table.HOLDING_REGISTERS, address, (word,)))
        client.close()
        await hostile.close()

    asyncio.run(doing())
    assert registers.words[1:3] == [7, 8]
    assert len(pauses_s) == 2
    assert min(pauses_s) > 0.9 * PAUSE_S
