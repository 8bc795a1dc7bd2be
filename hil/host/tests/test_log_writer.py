"""A log whose reader pauses: nothing waits for it, the order stays, and what is lost is counted."""

import logging
import os
from collections.abc import Iterator
from contextlib import suppress

import pytest

from hil.host.journal import JournalFormatter
from hil.host.log_writer import MOST, LogWriter

FILL = b"x" * 4096


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    reads, writes = os.pipe()
    yield reads, writes
    for fd in (reads, writes):
        with suppress(OSError):
            os.close(fd)


def record(text: str) -> logging.LogRecord:
    return logging.makeLogRecord({"msg": text, "levelno": logging.ERROR, "levelname": "ERROR"})


def read_all(reads: int) -> bytes:
    return b"".join(iter(lambda: os.read(reads, 65536), b""))


def test_messages_come_in_order_and_none_is_lost_at_the_end(pipe: tuple[int, int]) -> None:
    reads, writes = pipe
    writer = LogWriter(writes)
    writer.setFormatter(JournalFormatter())
    for number in range(100):
        writer.handle(record(f"{number}"))
    writer.close()
    writer.close()
    writer.handle(record("late"))
    os.close(writes)
    assert read_all(reads).decode().split() == [*(f"<3>{number}" for number in range(100)), "<3>late"]


def test_a_reader_that_pauses(pipe: tuple[int, int]) -> None:
    reads, writes = pipe
    os.set_blocking(writes, False)
    filled = 0
    with suppress(BlockingIOError):
        while True:
            filled += os.write(writes, FILL)
    os.set_blocking(writes, True)
    writer = LogWriter(writes)
    for number in range(MOST + 11):
        writer.handle(record(f"{number}"))
    left = filled
    while left:
        left -= len(os.read(reads, left))
    got = b""
    while b"\n4000\n" not in got:  # there is room again
        got += os.read(reads, 65536)
    writer.handle(record("last"))
    writer.close()
    os.close(writes)
    lines = (got + read_all(reads)).decode().splitlines()
    kept = len(lines) - 2
    assert kept in (MOST, MOST + 1)  # with the one that is being written
    assert lines[:kept] == [f"{number}" for number in range(kept)]
    assert lines[kept] == f"{MOST + 11 - kept} messages were dropped here, because nobody read the log"
    assert lines[-1] == "last"


def test_a_file_that_takes_nothing() -> None:
    with open("/dev/full", "wb", buffering=0) as full:
        for fd in (full.fileno(), None):
            writer = LogWriter(fd)
            writer.handle(record("lost"))
            writer.close()
