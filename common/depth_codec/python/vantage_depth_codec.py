#!/usr/bin/env python3
"""Decoder of Vantage's depth codec (docs/depth-codec.md). Needs numpy.

In a program:  depth = vantage_depth_codec.decode(bytes(image.data))
By itself:     vantage_depth_codec.py FILE...    writes FILE.pgm for each payload, 16 bits a pixel
"""
import sys

import numpy as np

STRIPS = 32
BANDS = 2
LANES = STRIPS * BANDS
MAX_SIDE = 4096
SYMBOLS = 8
CONTEXTS = 16
BUCKETS = 15
SCALE_BITS = 14
SCALE = 1 << SCALE_BITS
STATE_LOW = 1 << 16
BELOW, ZERO, ABOVE, INVALID = 0, 3, 6, 7

# Contexts of the steps between four measured neighbours, then those where one is not measured.
CONTEXT_OF = np.array([
    7, 7, 6, 6, 14, 7, 14, 14, 14, 14, 4, 7, 14, 14, 14, 7, 15, 14, 14, 14, 14, 14, 14, 14, 14,
    7, 7, 6, 6, 14, 7, 9, 12, 7, 14, 4, 3, 15, 5, 14, 7, 9, 5, 12, 14, 14, 14, 14, 14, 14,
    7, 4, 6, 6, 14, 4, 3, 10, 12, 11, 6, 2, 1, 9, 14, 7, 9, 5, 12, 14, 14, 14, 14, 12, 14,
    7, 4, 6, 6, 14, 4, 3, 10, 12, 14, 6, 4, 8, 12, 14, 6, 7, 15, 10, 14, 14, 14, 14, 12, 12,
    7, 7, 6, 14, 14, 6, 7, 4, 10, 14, 6, 6, 10, 12, 14, 6, 6, 12, 10, 12, 14, 14, 14, 12, 10,
    0, 11, 11, 11, 13, 13, 13, 7, 13, 11, 11, 11, 13, 13, 13, 0], np.int32)
GRADIENTS = 125


class DepthCodecError(ValueError):
    """The bytes are no image of the depth codec, or a damaged one."""


def _crc32c_table():
    table = []
    for crc in range(256):
        for _ in range(8):
            crc = (crc >> 1) ^ (0x82F63B78 if crc & 1 else 0)
        table.append(crc)
    return table


_CRC32C_TABLE = _crc32c_table()


def crc32c(data):
    """CRC-32C (RFC 3720) of bytes."""
    crc = 0xFFFFFFFF
    table = _CRC32C_TABLE
    for byte in data:
        crc = (crc >> 8) ^ table[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def _u16(data, at):
    return data[at] | (data[at + 1] << 8)


def _read_palette(data, at):
    """The values by rank, and where what follows begins."""
    if len(data) < at + 2:
        raise DepthCodecError("the palette is cut off")
    count = _u16(data, at)
    if count == 0:
        return np.zeros(1, np.uint16), at + 2
    if len(data) < at + 7:
        raise DepthCodecError("the palette is cut off")
    value, factor, k = _u16(data, at + 2), _u16(data, at + 4), data[at + 6]
    if value == 0 or factor == 0 or k > 15:
        raise DepthCodecError(f"a palette from {value} in steps of {factor} with {k} bits")
    at += 7
    end = 8 * (len(data) - at)
    bit = 0
    values = [0, value]
    for _ in range(count - 1):
        step = 0
        while True:
            if bit >= end or step >= 65536:
                raise DepthCodecError("the palette is damaged")
            one = (data[at + (bit >> 3)] >> (bit & 7)) & 1
            bit += 1
            if not one:
                break
            step += 1 << k
        if bit + k > end:
            raise DepthCodecError("the palette is cut off")
        for i in range(k):
            step += ((data[at + (bit >> 3)] >> (bit & 7)) & 1) << i
            bit += 1
        value += factor * (step + 1)
        if value >= 65536:
            raise DepthCodecError("the palette goes beyond 65535")
        values.append(value)
    return np.array(values, np.uint16), at + (bit + 7) // 8


def _read_frequencies(data, at, symbols):
    if len(data) < at + symbols:
        raise DepthCodecError("the frequencies are cut off")
    left_out = data[at]
    frequencies = [((4 + (code & 3)) << (code >> 2)) >> 2 for code in data[at + 1:at + symbols]]
    if (left_out >= symbols or max(data[at + 1:at + symbols]) > 55
            or sum(frequencies) >= SCALE):
        raise DepthCodecError("the frequencies are damaged")
    frequencies.insert(left_out, SCALE - sum(frequencies))
    return np.array(frequencies, np.int64)


def _starts(frequencies):
    return np.cumsum(frequencies) - frequencies


class _Coder:
    """The range coder of all lanes."""

    def __init__(self, states, words, buckets):
        self.x = states.astype(np.int64)
        self.words = words
        self.next = 0
        self.bucket_frequency = buckets.tolist()
        self.bucket_start = _starts(buckets).tolist()

    def refill(self, first, last):
        """Lanes first..last - 1 get a word each, where they need one."""
        x = self.x[first:last]
        low = np.flatnonzero(x < STATE_LOW)
        end = self.next + len(low)
        if end > len(self.words):
            raise DepthCodecError("the words end too early")
        if end > self.next:
            x[low] = (x[low] << 16) | self.words[self.next:end]
            self.next = end

    def distance(self, lane):
        """How far a residual lies beyond -2..2."""
        slot = int(self.x[lane]) & (SCALE - 1)
        bucket = BUCKETS - 1
        while self.bucket_start[bucket] > slot:
            bucket -= 1
        self.x[lane] = (self.bucket_frequency[bucket] * (int(self.x[lane]) >> SCALE_BITS) + slot
                        - self.bucket_start[bucket])
        self.refill(lane, lane + 1)
        x = int(self.x[lane])
        self.x[lane] = x >> bucket
        self.refill(lane, lane + 1)
        return (1 << bucket) | (x & ((1 << bucket) - 1))


def _with_neighbors(row):
    """Columns x lanes with the neighbouring strips' columns before and after."""
    padded = np.zeros((len(row) + 2, LANES), row.dtype)
    padded[1:-1, :row.shape[1]] = row
    padded[0, 1:] = padded[-2, :-1]
    padded[-1, :-1] = padded[1, 1:]
    padded[0, ::STRIPS] = 0
    padded[-1, STRIPS - 1::STRIPS] = 0
    return padded


def _decode_row(coder, tables, above, above_valid):
    """Ranks to predict from and flags of a row of the bands: columns x lanes, as above."""
    symbol_of, frequency, start = tables
    columns, lanes = len(above) - 2, above.shape[1]
    ranks = np.empty((columns, lanes), np.int16)
    valid = np.empty((columns, lanes), bool)
    # What does not depend on this row, for all of it.
    north, north_west, north_east = above[1:-1], above[:-2], above[2:]
    slope = north - north_west
    gradients = (25 * (np.clip(north_east - north, -2, 2).astype(np.int32) + 2)
                 + 5 * (np.clip(slope, -2, 2).astype(np.int32) + 2) + 2)
    flags = above_valid.astype(np.int32)
    others = GRADIENTS + 2 * flags[1:-1] + 4 * flags[:-2] + 8 * flags[2:]
    all_valid = others == GRADIENTS + 14
    west = above[0]
    west_valid = above_valid[0]
    for c in range(columns):
        step = np.minimum(np.maximum(west - north_west[c], -2), 2)
        context = CONTEXT_OF[np.where(all_valid[c] & west_valid, gradients[c] + step,
                                      others[c] + west_valid)]
        x = coder.x[:lanes]
        slot = x & (SCALE - 1)
        symbol = symbol_of[(context << SCALE_BITS) + slot]
        entry = (context << 3) + symbol
        coder.x[:lanes] = frequency[entry] * (x >> SCALE_BITS) + slot - start[entry]
        residual = (symbol - ZERO).astype(np.int16)
        far = (symbol == BELOW) | (symbol == ABOVE)
        if far.any():
            _decode_far(coder, symbol, np.flatnonzero(far), residual)
        else:
            coder.refill(0, lanes)
        predicted = np.maximum(np.minimum(west, north[c]),
                               np.minimum(west + slope[c], np.maximum(west, north[c])))
        west_valid = symbol != INVALID
        west = np.where(west_valid, predicted + residual, predicted)
        ranks[c] = west
        valid[c] = west_valid
    return ranks, valid


def _decode_far(coder, symbol, far, residual):
    """Band by band what is still to be told."""
    for first in range(0, len(symbol), STRIPS):
        coder.refill(first, first + STRIPS)
        for lane in far[(far >= first) & (far < first + STRIPS)]:
            distance = coder.distance(int(lane)) + 2
            distance = distance if symbol[lane] == ABOVE else -distance
            residual[lane] = (distance + 32768) % 65536 - 32768


def _decode_coded(data, at, width, height):
    values, at = _read_palette(data, at)
    frequency = []
    for _ in range(CONTEXTS):
        frequency.append(_read_frequencies(data, at, SYMBOLS))
        at += SYMBOLS
    start = np.concatenate([_starts(f) for f in frequency])
    symbol_of = np.concatenate([np.repeat(np.arange(SYMBOLS, dtype=np.int32), f)
                                for f in frequency])
    tables = symbol_of, np.concatenate(frequency), start
    buckets = _read_frequencies(data, at, BUCKETS)
    at += BUCKETS
    if len(data) < at + 4 * LANES or (len(data) - at) % 2 != 0:
        raise DepthCodecError("the states are cut off")
    states = np.frombuffer(data, "<u4", LANES, at)
    if (states < STATE_LOW).any():
        raise DepthCodecError("a state is out of range")
    words = np.frombuffer(data, "<u2", -1, at + 4 * LANES).astype(np.int64)
    coder = _Coder(states, words, buckets)

    columns = -(-width // STRIPS)
    rows = -(-height // BANDS)
    image = np.zeros((BANDS * rows, STRIPS * columns), np.uint16)
    above = np.zeros((columns + 2, LANES), np.int16)
    above_valid = np.zeros((columns + 2, LANES), bool)
    for row in range(rows):
        bands = BANDS if rows + row < height else 1
        lanes = STRIPS * bands
        ranks, valid = _decode_row(coder, tables, above[:, :lanes], above_valid[:, :lanes])
        index = ranks.astype(np.uint16).astype(np.int64)
        if (valid & ((index == 0) | (index >= len(values)))).any():
            raise DepthCodecError("a rank is beyond the palette")
        pixels = values[np.where(valid, index, 0)]
        for band in range(bands):
            strips = pixels[:, STRIPS * band:STRIPS * (band + 1)]
            image[row + band * rows] = strips.T.reshape(-1)
        above = _with_neighbors(ranks)
        above_valid = _with_neighbors(valid)
    if coder.next != len(coder.words) or (coder.x != STATE_LOW).any():
        raise DepthCodecError("states or words are left over")
    return image[:height, :width].copy()


def _decode_window(data, at, width, height):
    if len(data) < at + 8:
        raise DepthCodecError("the window is cut off")
    left, top, wide, high = (_u16(data, at + 2 * i) for i in range(4))
    if wide == 0 or high == 0 or left + wide > width or top + high > height:
        raise DepthCodecError(f"its window is {wide} x {high} px at ({left}, {top})")
    image = np.zeros((height, width), np.uint16)
    image[top:top + high, left:left + wide] = _decode_coded(data, at + 8, wide, high)
    return image


def decode(payload):
    """The image of a payload: height x width, uint16. Raises DepthCodecError."""
    data = bytes(payload)
    if len(data) < 13:
        raise DepthCodecError(f"{len(data)} bytes, expected a header of 13")
    if data[:4] != b"VDC\x01":
        raise DepthCodecError('it does not begin with "VDC" and version 1')
    if int.from_bytes(data[4:8], "little") != crc32c(data[8:]):
        raise DepthCodecError("its checksum does not fit its bytes")
    width, height, mode = _u16(data, 8), _u16(data, 10), data[12]
    if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE):
        raise DepthCodecError(f"it is {width} x {height} px, expected sides of 1 to {MAX_SIDE}")
    if mode == 0:
        if len(data) != 13 + 2 * width * height:
            raise DepthCodecError(f"{len(data) - 13} bytes of pixels, "
                                  f"expected {2 * width * height}")
        return np.frombuffer(data, "<u2", -1, 13).reshape(height, width).astype(np.uint16)
    if mode == 1:
        return _decode_coded(data, 13, width, height)
    if mode == 2:
        return _decode_window(data, 13, width, height)
    raise DepthCodecError(f"its mode is {mode}, expected 0 to 2")


def _write_pgm(image, name):
    with open(name, "wb") as file:
        file.write(b"P5\n%d %d\n65535\n" % (image.shape[1], image.shape[0]))
        file.write(image.astype(">u2").tobytes())


def main(names):
    if not names or names[0] in ("-h", "--help"):
        print(__doc__)
        return 0 if names else 2
    failed = 0
    for name in names:
        try:
            with open(name, "rb") as file:
                image = decode(file.read())
            _write_pgm(image, name + ".pgm")
        except (OSError, DepthCodecError) as error:
            print(f"{name}: {error}", file=sys.stderr)
            failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
