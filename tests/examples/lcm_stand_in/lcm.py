"""As much of LCM's Python module as the robot adapter needs, in plain Python: for tests where the real
one is not installed. UDP multicast as LCM has it: short messages ("LC02") and fragments ("LC03")."""
import os
import re
import select
import socket
import struct
import time
import urllib.parse

_SHORT = 0x4C433032
_FRAGMENT = 0x4C433033
_LARGEST_SHORT = 1400  # bytes of channel and data
_FRAGMENT_BYTES = 1300
_LARGEST = 64 * 1024 * 1024


class LCM:
    def __init__(self, url=""):
        url = url or os.environ.get("LCM_DEFAULT_URL", "") or "udpm://239.255.76.67:7667?ttl=0"
        parsed = urllib.parse.urlparse(url)
        options = dict(urllib.parse.parse_qsl(parsed.query))
        self._to = (parsed.hostname or "239.255.76.67", parsed.port or 7667)
        self._subscriptions = []
        self._sequence = 0
        self._parts = {}  # (sender, sequence): [size, {offset: bytes}, channel]
        self._in = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._in.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._in.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, int(options.get("recv_buf_size", 1 << 22)))
        self._in.bind(("", self._to[1]))
        member = struct.pack("4sl", socket.inet_aton(self._to[0]), socket.INADDR_ANY)
        self._in.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
        self._out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, int(options.get("ttl", 0)))

    def subscribe(self, channel, handler):
        self._subscriptions.append((re.compile(channel), handler))

    def publish(self, channel, data):
        name = channel.encode() + b"\0"
        self._sequence = (self._sequence + 1) & 0xFFFFFFFF
        if len(name) + len(data) <= _LARGEST_SHORT:
            self._out.sendto(struct.pack(">II", _SHORT, self._sequence) + name + data, self._to)
            return
        pieces = [data[at:at + _FRAGMENT_BYTES] for at in range(0, len(data), _FRAGMENT_BYTES)]
        for number, piece in enumerate(pieces):
            head = struct.pack(">IIIIHH", _FRAGMENT, self._sequence, len(data),
                               number * _FRAGMENT_BYTES, number, len(pieces))
            self._out.sendto(head + (name if number == 0 else b"") + piece, self._to)

    def handle_timeout(self, milliseconds):
        """Handles one message of a subscribed channel. Returns 0 when none came in time."""
        end = time.monotonic() + milliseconds / 1000
        while select.select([self._in], [], [], max(0.0, end - time.monotonic()))[0]:
            channel, data = self._whole_message(*self._in.recvfrom(65536)) or (None, None)
            handlers = [handler for pattern, handler in self._subscriptions
                        if channel is not None and pattern.fullmatch(channel)]
            for handler in handlers:
                handler(channel, data)
            if handlers:
                return 1
        return 0

    def _whole_message(self, packet, sender):
        if len(packet) < 8:
            return None
        magic, sequence = struct.unpack_from(">II", packet)
        if magic == _SHORT:
            name, _, data = packet[8:].partition(b"\0")
            return name.decode(errors="replace"), data
        if magic != _FRAGMENT or len(packet) < 20:
            return None
        size, offset, number, _ = struct.unpack_from(">IIHH", packet, 8)
        if size > _LARGEST:
            return None
        name, data = (packet[20:].split(b"\0", 1) + [b""])[:2] if number == 0 else (None, packet[20:])
        if len(self._parts) > 100:
            self._parts.pop(next(iter(self._parts)))
        message = self._parts.setdefault((sender, sequence), [size, {}, None])
        message[1][offset] = data
        message[2] = name if name is not None else message[2]
        if sum(map(len, message[1].values())) < message[0] or message[2] is None:
            return None
        del self._parts[(sender, sequence)]
        return message[2].decode(errors="replace"), b"".join(part for _, part in sorted(message[1].items()))
