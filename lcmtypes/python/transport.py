"""LCM's UDP multicast and its log files, without LCM's own Python module (Debian has none).

LCM and EventLog have the names and the calls of `import lcm` that they share with it, so either
will do. Format: docs/reference/wire.md, and udp_multicast_protocol.md of lcm-proj/lcm.
"""

import re
import select
import socket
import struct
import urllib.parse

_WHOLE, _FRAGMENT = 0x4C433032, 0x4C433033  # "LC02", "LC03"
_MOST_BYTES = 65487  # of channel and data in one datagram
_MOST_PIECES = 64  # messages that lack a fragment, kept at a time
_EVENT = 0xEDA1DA01


class LCM:
    """A bus: LCM("udpm://239.255.76.67:7667?ttl=0"). With a muster.seal.Seal what is published has
    a tag, and what comes without the right one is dropped, and counted in `refused`."""

    def __init__(self, url, seal=None):
        self._seal = seal
        self.refused = 0
        parts = urllib.parse.urlsplit(url)
        options = dict(urllib.parse.parse_qsl(parts.query))
        self._to = (parts.hostname, parts.port)
        self._seq = 0
        self._handlers = []
        self._pieces = {}  # (sender's address, number): [bytes still missing, channel, data]
        self._out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, int(options.get("ttl", 0)))
        self._in = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        for option in (socket.SO_REUSEADDR, socket.SO_REUSEPORT):
            self._in.setsockopt(socket.SOL_SOCKET, option, 1)
        if "recv_buf_size" in options:
            size = int(options["recv_buf_size"])
            self._in.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, size)
        self._in.bind(("", parts.port))
        group = socket.inet_aton(parts.hostname) + socket.inet_aton("0.0.0.0")
        self._in.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)

    def subscribe(self, channel, handler):
        """Calls handler(channel, data) for channels that the regular expression matches."""
        self._handlers.append((re.compile(channel), handler))

    def publish(self, channel, data):
        if self._seal:
            data = self._seal.close(channel, data)
        name = channel.encode() + b"\0"
        self._seq = (self._seq + 1) % 2**32
        if len(name) + len(data) <= _MOST_BYTES:
            self._out.sendto(struct.pack(">II", _WHOLE, self._seq) + name + data, self._to)
            return
        whole = name + data
        parts = [whole[at : at + _MOST_BYTES] for at in range(0, len(whole), _MOST_BYTES)]
        offset = 0
        for number, part in enumerate(parts):
            head = struct.pack(
                ">IIIIHH", _FRAGMENT, self._seq, len(data), offset, number, len(parts)
            )
            self._out.sendto(head + part, self._to)
            offset += len(part) - (len(name) if number == 0 else 0)

    def handle_timeout(self, milliseconds):
        """Waits for one message and handles it; false when none came."""
        if not select.select([self._in], [], [], milliseconds / 1000)[0]:
            return False
        packet, sender = self._in.recvfrom(65536)
        message = self._open(packet, sender)
        if not message:
            return True
        channel, data = message
        handlers = [handler for pattern, handler in self._handlers if pattern.fullmatch(channel)]
        if handlers and self._seal:
            data = self._seal.open(channel, data)
            if data is None:
                self.refused += 1
                return True
        for handler in handlers:
            handler(channel, data)
        return True

    def _open(self, packet, sender):
        """(channel, data) of a whole message, None otherwise."""
        magic = int.from_bytes(packet[:4], "big")
        if magic == _WHOLE:
            channel, _, data = packet[8:].partition(b"\0")
            return channel.decode(errors="replace"), data
        if magic != _FRAGMENT or len(packet) < 20:
            return None
        _, seq, size, offset, number, _ = struct.unpack_from(">IIIIHH", packet)
        piece = self._pieces.setdefault((sender, seq), [size, None, {}])
        data = packet[20:]
        if number == 0:
            channel, _, data = data.partition(b"\0")
            piece[1] = channel.decode(errors="replace")
        if offset not in piece[2]:
            piece[2][offset] = data
            piece[0] -= len(data)
        if piece[0] == 0 and piece[1] is not None:
            del self._pieces[sender, seq]
            return piece[1], b"".join(data for _, data in sorted(piece[2].items()))
        while len(self._pieces) > _MOST_PIECES:
            del self._pieces[next(iter(self._pieces))]
        return None


class Event:
    def __init__(self, eventnum, timestamp, channel, data):
        self.eventnum = eventnum
        self.timestamp = timestamp  # of receipt, microseconds since the Unix epoch
        self.channel = channel
        self.data = data


class EventLog:
    """The events of a log in order, up to the first damage: for event in EventLog(path)."""

    def __init__(self, path):
        self._file = open(path, "rb")

    def __iter__(self):
        return self

    def __next__(self):
        head = self._file.read(28)
        if len(head) < 28:
            raise StopIteration
        sync, number, timestamp, channel_bytes, data_bytes = struct.unpack(">IqqII", head)
        channel, data = self._file.read(channel_bytes), self._file.read(data_bytes)
        if sync != _EVENT or len(data) < data_bytes:
            raise StopIteration
        return Event(number, timestamp, channel.decode(errors="replace"), data)
