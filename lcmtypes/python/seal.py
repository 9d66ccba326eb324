"""The tag behind each message of a sealed mission (docs/guide/seal.md): keyed BLAKE2b of Python's own
hashlib, over the channel's name, a NUL and the message."""

import hashlib
import hmac
import os
import stat
import sys

TAG_BYTES = 16


class Seal:
    """seal = Seal.load("FILE or -", run_id); lcm = muster.transport.LCM(url, seal)"""

    def __init__(self, text, run_id):
        """text: 64 hexadecimal digits, and the run id where it is the key of one run."""
        digits, *run = text.split()
        key = bytes.fromhex(digits)
        if len(key) != 32 or len(run) > 1:
            raise ValueError("no key: 64 hexadecimal digits, and perhaps a run id")
        if run and int(run[0]) != run_id:
            raise ValueError(f"the key of run {run[0]}, expected one of run {run_id}")
        if not run:
            name = f"muster run {run_id}".encode()
            key = hashlib.blake2b(name, key=key, digest_size=32).digest()
        self._key = key

    @classmethod
    def load(cls, path, run_id):
        """From the first line of stdin ("-"), or of a file that its owner alone can read."""
        if path == "-":
            return cls(sys.stdin.readline(), run_id)
        with open(path) as file:
            status = os.fstat(file.fileno())
            if stat.S_ISREG(status.st_mode) and status.st_mode & 0o077:
                raise ValueError(f"{path}: others can read it (chmod 600)")
            return cls(file.readline(), run_id)

    def _tag(self, channel, data):
        text = channel.encode() + b"\0" + data
        return hashlib.blake2b(text, key=self._key, digest_size=TAG_BYTES).digest()

    def close(self, channel, data):
        """The message with its tag."""
        return data + self._tag(channel, data)

    def open(self, channel, data):
        """The message without its tag; None where that is not the right one."""
        message, tag = data[:-TAG_BYTES], data[-TAG_BYTES:]
        right = len(data) >= TAG_BYTES and hmac.compare_digest(tag, self._tag(channel, message))
        return message if right else None
