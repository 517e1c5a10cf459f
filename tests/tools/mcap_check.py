#!/usr/bin/env python3
"""Reads an MCAP file by https://mcap.dev/spec, sharing no code with the writer, and ends with 1 at
the first thing that is not as it says: lengths of records, checksums, offsets of the index,
statistics, order, and JSON messages against their JSON schemas. Prints what is in the file.

usage: mcap_check.py FILE"""

import base64
import ctypes
import ctypes.util
import json
import struct
import sys
import zlib

MAGIC = b'\x89MCAP0\r\n'
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
STATISTICS, SUMMARY_OFFSET, DATA_END = 0x0B, 0x0E, 0x0F


def require(condition, what):
    if not condition:
        sys.exit(f'mcap_check: {what}')


class Reader:
    """Fields of a record's content."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def number(self, code):
        size = struct.calcsize(code)
        require(self.at + size <= len(self.data), 'a record is shorter than its fields')
        value = struct.unpack_from('<' + code, self.data, self.at)[0]
        self.at += size
        return value

    def raw(self, size):
        require(self.at + size <= len(self.data), 'a record is shorter than its fields')
        self.at += size
        return self.data[self.at - size:self.at]

    def text(self):
        return self.raw(self.number('I')).decode('utf-8')

    def pairs(self, first, second):
        inner = Reader(self.raw(self.number('I')))
        found = []
        while inner.at < len(inner.data):
            found.append((inner.number(first), inner.number(second)))
        return found

    def end(self, what):
        require(self.at == len(self.data), f'{what} has {len(self.data) - self.at} bytes too many')


def records(data, begin, end, what):
    """Yields (offset, opcode, content)."""
    at = begin
    while at < end:
        require(at + 9 <= end, f'{what} ends inside a record')
        opcode, size = struct.unpack_from('<BQ', data, at)
        require(at + 9 + size <= end, f'{what}: record {opcode:#x} at {at} goes past its end')
        yield at, opcode, data[at + 9:at + 9 + size]
        at += 9 + size


def zstd(data, size):
    library = ctypes.CDLL(ctypes.util.find_library('zstd') or 'libzstd.so.1')
    library.ZSTD_decompress.restype = ctypes.c_size_t
    buffer = ctypes.create_string_buffer(size + 1)
    got = library.ZSTD_decompress(buffer, ctypes.c_size_t(size + 1), data,
                                  ctypes.c_size_t(len(data)))
    require(got == size, f'a chunk has {got} bytes without compression, not {size}')
    return buffer.raw[:size]


TYPES = {'object': dict, 'array': list, 'string': str, 'boolean': bool, 'integer': int,
         'number': (int, float, type(None))}


def validate(value, schema, place):
    """The part of JSON Schema that is used here. A number that is not finite is null."""
    kind = schema.get('type')
    require(kind in TYPES, f'{place}: type {kind} is none')
    require(isinstance(value, TYPES[kind]) and (kind == 'boolean' or not isinstance(value, bool)),
            f'{place}: {value!r:.40} is no {kind}')
    if kind == 'object':
        for name in schema.get('required', []):
            require(name in value, f'{place}: {name} is missing')
        for name, each in value.items():
            require(name in schema['properties'], f'{place}: {name} is not in the schema')
            validate(each, schema['properties'][name], f'{place}.{name}')
    elif kind == 'array':
        require(schema.get('minItems', 0) <= len(value) <= schema.get('maxItems', len(value)),
                f'{place}: {len(value)} items')
        for each in value:
            validate(each, schema['items'], place + '[]')
    elif schema.get('contentEncoding') == 'base64':
        base64.b64decode(value, validate=True)


def check_image(message, place):
    size = len(base64.b64decode(message['data']))
    pixel = {'16UC1': 2, 'rgb8': 3}[message['encoding']]
    require(message['step'] == pixel * message['width'], f'{place}: step {message["step"]}')
    require(size == message['step'] * message['height'], f'{place}: {size} bytes of data')


class File:
    def __init__(self, data):
        self.data = data
        self.schemas, self.channels, self.counts = {}, {}, {}
        self.chunks, self.indices, self.last_sequence = {}, {}, {}
        self.first = self.last = None

    def schema(self, content):
        reader = Reader(content)
        number, name = reader.number('H'), reader.text()
        encoding, text = reader.text(), reader.raw(reader.number('I'))
        reader.end('a schema')
        require(number != 0, 'a schema has number 0')
        require(encoding == 'jsonschema', f'schema {name} is of {encoding}')
        schema = (name, json.loads(text))
        require(self.schemas.setdefault(number, schema) == schema, f'schema {number} is two')

    def channel(self, content):
        reader = Reader(content)
        number, schema = reader.number('H'), reader.number('H')
        channel = (schema, reader.text(), reader.text())
        require(reader.raw(reader.number('I')) == b'', 'a channel has metadata')
        reader.end('a channel')
        require(schema == 0 or schema in self.schemas, f'{channel[1]}: schema {schema} unknown')
        require(self.channels.setdefault(number, channel) == channel, f'channel {number} is two')

    def message(self, content):
        reader = Reader(content)
        number, sequence = reader.number('H'), reader.number('I')
        log_time, _ = reader.number('Q'), reader.number('Q')
        require(number in self.channels, f'a message of channel {number}, which is none')
        schema, topic, encoding = self.channels[number]
        require(sequence == self.last_sequence.get(number, -1) + 1, f'{topic}: sequence {sequence}')
        self.last_sequence[number] = sequence
        self.counts[number] = self.counts.get(number, 0) + 1
        self.first = log_time if self.first is None else min(self.first, log_time)
        self.last = log_time if self.last is None else max(self.last, log_time)
        if encoding == 'json':
            name, text = self.schemas[schema]
            message = json.loads(content[reader.at:].decode('utf-8'))
            validate(message, text, topic)
            if name == 'foxglove.RawImage':
                check_image(message, topic)
        else:
            require((schema, encoding) == (0, 'x-lcm'), f'{topic} is encoded as {encoding}')
        return number, log_time

    def chunk(self, offset, content):
        reader = Reader(content)
        first, last = reader.number('Q'), reader.number('Q')
        size, crc = reader.number('Q'), reader.number('I')
        compression, packed = reader.text(), reader.raw(reader.number('Q'))
        reader.end('a chunk')
        require(compression == 'zstd', f'a chunk is compressed by {compression}')
        inside = zstd(packed, size)
        require(zlib.crc32(inside) == crc, f'the chunk at {offset} has another checksum')
        index, times = {}, []
        for at, opcode, each in records(inside, 0, len(inside), 'a chunk'):
            if opcode == MESSAGE:
                number, time = self.message(each)
                index.setdefault(number, []).append((time, at))
                times.append(time)
            else:
                require(opcode in (SCHEMA, CHANNEL), f'record {opcode:#x} in a chunk')
                (self.schema if opcode == SCHEMA else self.channel)(each)
        require((first, last) == (min(times, default=0), max(times, default=0)),
                f'the chunk at {offset} has other times than it says')
        self.chunks[offset] = (first, last, offset, 9 + len(content), compression, len(packed), size)
        self.indices[offset] = {}
        return index

    def data_section(self, begin):
        """Returns where it ends."""
        open_index, chunk = {}, None
        for at, opcode, content in records(self.data, begin, len(self.data) - 8, 'the file'):
            if opcode != MESSAGE_INDEX:
                require(not open_index, f'channels {list(open_index)} of a chunk are not indexed')
            if opcode == CHUNK:
                chunk, open_index = at, self.chunk(at, content)
            elif opcode == MESSAGE_INDEX:
                reader = Reader(content)
                number, entries = reader.number('H'), reader.pairs('Q', 'Q')
                reader.end('a message index')
                require(open_index.pop(number, None) == entries,
                        f'the index at {at} of channel {number} is wrong')
                self.indices[chunk][number] = (at, 9 + len(content))
            else:
                require(opcode == DATA_END, f'record {opcode:#x} at {at}, outside of chunks')
                reader = Reader(content)
                crc = reader.number('I')
                reader.end('the end of data')
                require(crc == zlib.crc32(self.data[:at]), 'the data have another checksum')
                return at + 9 + len(content)
        return require(False, 'there is no end of data')

    def summary(self, begin, end, offsets_end):
        before = (dict(self.schemas), dict(self.channels))
        schemas, channels, groups, listed = set(), set(), {}, set()
        for at, opcode, content in records(self.data, begin, end, 'the summary'):
            size = 9 + len(content)
            start, length, last = groups.get(opcode, (at, 0, at))
            require(last == at, f'records {opcode:#x} of the summary are not together')
            groups[opcode] = (start, length + size, at + size)
            reader = Reader(content)
            if opcode == SCHEMA:
                self.schema(content)
                schemas.add(reader.number('H'))
            elif opcode == CHANNEL:
                self.channel(content)
                channels.add(reader.number('H'))
            elif opcode == STATISTICS:
                self.statistics(reader)
            else:
                require(opcode == CHUNK_INDEX, f'record {opcode:#x} in the summary')
                listed.add(self.chunk_index(reader))
        require((schemas, channels) == (set(before[0]), set(before[1])),
                'the summary has not the schemas and channels of the data')
        require(listed == set(self.chunks), 'the summary has not every chunk')
        for at, opcode, content in records(self.data, end, offsets_end, 'the summary offsets'):
            reader = Reader(content)
            require(opcode == SUMMARY_OFFSET, f'record {opcode:#x} among the summary offsets')
            start, length, _ = groups.pop(reader.number('B'))
            require((start, length) == (reader.number('Q'), reader.number('Q')),
                    f'the summary offset at {at} is wrong')
            reader.end('a summary offset')
        require(not groups, 'a group of the summary has no offset')

    def statistics(self, reader):
        found = [reader.number(code) for code in 'QHIIIIQQ']
        require(found == [sum(self.counts.values()), len(self.schemas), len(self.channels), 0, 0,
                          len(self.chunks), self.first or 0, self.last or 0],
                f'the statistics are wrong: {found}')
        require(dict(reader.pairs('H', 'Q')) == {n: self.counts.get(n, 0) for n in self.channels},
                'the counts of messages are wrong')
        reader.end('the statistics')

    def chunk_index(self, reader):
        first, last, offset, length = [reader.number('Q') for _ in range(4)]
        places, size = reader.pairs('H', 'Q'), reader.number('Q')
        compression, packed, unpacked = reader.text(), reader.number('Q'), reader.number('Q')
        reader.end('a chunk index')
        require((first, last, offset, length, compression, packed, unpacked)
                == self.chunks.get(offset), f'the index of the chunk at {offset} is wrong')
        known = self.indices[offset]
        require(dict(places) == {number: at for number, (at, _) in known.items()}
                and size == sum(each for _, each in known.values()),
                f'the chunk at {offset} has its messages indexed elsewhere')
        return offset

    def check(self):
        data = self.data
        require(data[:8] == MAGIC and data[-8:] == MAGIC, 'no MCAP magic at the start and the end')
        start, opcode, header = next(records(data, 8, len(data) - 8, 'the file'))
        require(opcode == HEADER, 'the first record is no header')
        reader = Reader(header)
        require(reader.text() == '', 'the profile is not empty')
        library = reader.text()
        reader.end('the header')
        end = self.data_section(start + 9 + len(header))
        footer = len(data) - 8 - 29
        require(struct.unpack_from('<BQ', data, footer) == (FOOTER, 20), 'no footer at the end')
        summary, offsets, crc = struct.unpack_from('<QQI', data, footer + 9)
        require(summary == end, 'the summary does not follow the data')
        require(summary <= offsets <= footer, 'the summary offsets are elsewhere')
        require(crc == zlib.crc32(data[summary:footer + 25]), 'the summary has another checksum')
        self.summary(summary, offsets, footer)
        print(f'{library}: {sum(self.counts.values())} messages, {len(self.chunks)} chunks')
        for number, (schema, topic, _) in sorted(self.channels.items(), key=lambda item: item[1][1]):
            name = self.schemas[schema][0] if schema else '-'
            print(f'{topic} {name} {self.counts.get(number, 0)}')


def main():
    require(len(sys.argv) == 2, __doc__.splitlines()[-1])
    with open(sys.argv[1], 'rb') as file:
        data = file.read()
    try:
        File(data).check()
    except (ValueError, KeyError, struct.error, RecursionError) as error:
        sys.exit(f'mcap_check: {error!r}')


main()
