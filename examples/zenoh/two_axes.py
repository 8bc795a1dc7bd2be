"""Moves two axes of a running bench together, from another process: two_axes.py [BENCH [ENDPOINT]]."""

import asyncio
import sys

from hil.client import connect


async def main() -> None:
    async with connect(*(sys.argv[1:] or ["zen"])) as bench:
        m1, s1 = bench.axis("m1"), bench.axis("s1")
        await m1.enable()
        await asyncio.gather(m1.move_abs(90, 120, wait=True), s1.move_rel(-45, 60, wait=True))
        for axis in (m1, s1):
            print(f"{axis.name} at {(await axis.state()).position_deg:.0f} deg")


asyncio.run(main())
