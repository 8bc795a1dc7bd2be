"""A file of MCAP, written chunk by chunk: needs the extra ``mcap``.

The records are those of the library. Only messages and their index, a million in an hour of samples, are
packed here in one go: the library's own writer takes five times as long for each. Source: the MCAP
specification, mcap.dev/spec.
"""

import json
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping
from struct import Struct, pack
from typing import Any, BinaryIO

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Footer, Header, McapRecord, Schema, Statistics
from mcap.writer import MCAP0_MAGIC
from zstandard import compress

CHUNK_BYTES = 4 << 20
_MESSAGE = Struct("<BQHIQQ")
_OWN_BYTES = _MESSAGE.size - 9
"""Bytes of a message beside its data: channel, sequence, and two times."""
_FOOTER = Struct("<BQQQ")


class McapFile:
    """Writer of a file. Times are in ns since 1970. Messages of one channel come in the order of time."""

    def __init__(self, file: BinaryIO, program: str) -> None:
        self._file, self._at = file, 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._parts: list[bytes] = []
        """Messages of the chunk."""
        self._size = 0
        self._index: dict[int, list[int]] = {}
        """Times and places of the chunk's messages, one behind the other, by channel."""
        self._chunks: list[ChunkIndex] = []
        self._counts = Counter[int]()
        self._write(MCAP0_MAGIC)
        self._write_records(Header("", program))

    @property
    def messages(self) -> int:
        """Number of messages so far."""
        return self._counts.total()

    def channel(self, topic: str, name: str, schema: Mapping[str, Any], **metadata: str) -> int:
        """Begin a channel of messages in JSON; ``name``: that of their JSON schema. Answers its number."""
        made = Schema(len(self._schemas) + 1, json.dumps(schema).encode(), "jsonschema", name)
        number = len(self._channels) + 1
        channel = Channel(number, topic, "json", metadata, made.id)
        self._schemas.append(made)
        self._channels.append(channel)
        self._write_records(made, channel)
        return number

    def add(self, channel: int, messages: Iterable[tuple[int, bytes]]) -> None:
        """Add messages of a channel, each its time and text."""
        parts, index, at = self._parts, self._index.setdefault(channel, []), self._size
        packed, count = _MESSAGE.pack, self._counts[channel]
        for at_ns, data in messages:
            parts.append(packed(Opcode.MESSAGE, _OWN_BYTES + len(data), channel, count, at_ns, at_ns))
            parts.append(data)
            index += (at_ns, at)
            at += _MESSAGE.size + len(data)
            count += 1
        self._size, self._counts[channel] = at, count
        if at >= CHUNK_BYTES:
            self._end_chunk()

    def _end_chunk(self) -> None:
        index = {channel: flat for channel, flat in self._index.items() if flat}
        if not index:
            return
        plain = b"".join(self._parts)
        data = compress(plain)
        first_ns, last_ns = (
            min(min(flat[::2]) for flat in index.values()),
            max(max(flat[::2]) for flat in index.values()),
        )
        begin = self._at
        self._write_records(Chunk("zstd", data, last_ns, first_ns, zlib.crc32(plain), len(plain)))
        length, offsets, indices_at = self._at - begin, dict[int, int](), self._at
        for channel, flat in index.items():
            offsets[channel] = self._at
            body = pack(f"<HI{len(flat)}Q", channel, 8 * len(flat), *flat)
            self._write(pack("<BQ", Opcode.MESSAGE_INDEX, len(body)) + body)
        self._chunks.append(
            ChunkIndex(
                length,
                begin,
                "zstd",
                len(data),
                last_ns,
                self._at - indices_at,
                offsets,
                first_ns,
                len(plain),
            )
        )
        self._parts, self._size, self._index = [], 0, {}

    def finish(self) -> None:
        """Write what waits, and the summary by which readers find it."""
        self._end_chunk()
        self._write_records(DataEnd(0))
        times_ns = [(each.message_start_time, each.message_end_time) for each in self._chunks]
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts={number: count for number, count in self._counts.items() if count},
            chunk_count=len(self._chunks),
            message_count=self._counts.total(),
            message_end_time=max((last for _, last in times_ns), default=0),
            message_start_time=min((first for first, _ in times_ns), default=0),
            metadata_count=0,
            schema_count=len(self._schemas),
        )
        summary, begin = _encoded(*self._schemas, *self._channels, statistics, *self._chunks), self._at
        head = _FOOTER.pack(Opcode.FOOTER, 8 + 8 + 4, begin, 0)
        self._write(summary)
        self._write_records(Footer(begin, 0, zlib.crc32(head, zlib.crc32(summary))))
        self._write(MCAP0_MAGIC)

    def _write_records(self, *records: McapRecord) -> None:
        self._write(_encoded(*records))

    def _write(self, data: bytes) -> None:
        self._file.write(data)
        self._at += len(data)


def _encoded(*records: McapRecord) -> bytes:
    built = RecordBuilder()
    for each in records:
        each.write(built)
    data: bytes = built.end()
    return data
