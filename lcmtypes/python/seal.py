"""The tag behind each message of a sealed mission (docs/guide/seal.md): keyed BLAKE2b of Python's own
hashlib, over the channel's name, a NUL and the message; sealed per process, the sender's Ed25519
signature of the same text, by libsodium."""

import ctypes
import ctypes.util
import hashlib
import hmac
import json
import os
import stat
import struct
import sys

TAG_BYTES = 16
SIGNATURE_BYTES = 64
_WORLD = ("world",)
_DECIDERS = ("world", "scheduler")
# Who may speak on what an agent process hears; the launcher's name comes with the keys.
_SPEAKERS = {
    "MUSTER_SCENARIO": _WORLD,
    "MUSTER_ROADS": _WORLD,
    "MUSTER_CLOCK": _WORLD,
    "MUSTER_WORLD": _WORLD,
    "MUSTER_RULINGS": _WORLD,
    "MUSTER_ORDERS": _WORLD,
    "MUSTER_SCHEDULE": _DECIDERS,
    "MUSTER_CLEARANCES": _DECIDERS,
    "MUSTER_LOG": ("recorder",),
}


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
            return cls.of(sys.stdin.readline(), run_id)
        with open(path) as file:
            status = os.fstat(file.fileno())
            if stat.S_ISREG(status.st_mode) and status.st_mode & 0o077:
                raise ValueError(f"{path}: others can read it (chmod 600)")
            return cls.of(file.readline(), run_id)

    @classmethod
    def of(cls, text, run_id):
        """The seal of what stands in a key file: of the mission, or of one process."""
        return ProcessSeal(text, run_id) if text.startswith("{") else cls(text, run_id)

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


def _sender(data):
    """header_t.sender of a message: behind its fingerprint and run_id."""
    (size,) = struct.unpack_from(">i", data, 16)
    if size < 1 or 20 + size > len(data):
        raise ValueError("no sender")
    return data[20 : 19 + size].decode()


class ProcessSeal:
    """The same of a mission that is sealed per process. text: one line of JSON, as in keys/."""

    def __init__(self, text, run_id):
        keys = json.loads(text)
        if keys["version"] != 1 or keys["run_id"] != run_id:
            raise ValueError(f"the keys of run {keys['run_id']}, expected those of run {run_id}")
        self._sodium = ctypes.CDLL(ctypes.util.find_library("sodium") or "libsodium.so.23")
        if self._sodium.sodium_init() < 0:
            raise OSError("libsodium does not start")
        self._launcher = keys["launcher"]
        self._public = {n: bytes.fromhex(m["public"]) for n, m in keys["members"].items()}
        self._secret = {}
        for name, member in keys["members"].items():
            if "secret" in member:
                self._secret[name] = bytes.fromhex(member["secret"]) + self._public[name]

    def _may_say(self, channel, sender):
        if channel in ("MUSTER_FAULT", "MUSTER_ORDER"):
            return sender == self._launcher
        if channel == "MUSTER_ANSWER":
            return sender in (self._launcher, "world")
        return sender in _SPEAKERS.get(channel, (sender,))

    def close(self, channel, data):
        """The message with its sender's signature."""
        text = channel.encode() + b"\0" + data
        signature = ctypes.create_string_buffer(SIGNATURE_BYTES)
        key = self._secret[_sender(data)]
        self._sodium.crypto_sign_detached(
            signature, None, text, ctypes.c_ulonglong(len(text)), key
        )
        return data + signature.raw

    def open(self, channel, data):
        """The message without its signature; None where that is not its sender's, or its sender
        may not say so."""
        message, signature = data[:-SIGNATURE_BYTES], data[-SIGNATURE_BYTES:]
        try:
            sender = _sender(message)
            public = self._public[sender]
        except (KeyError, ValueError, struct.error):
            return None
        text = channel.encode() + b"\0" + message
        right = 0 == self._sodium.crypto_sign_verify_detached(
            signature, text, ctypes.c_ulonglong(len(text)), public
        )
        return message if right and self._may_say(channel, sender) else None
