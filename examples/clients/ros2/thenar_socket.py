"""The socket half of the client: what ``thenar serve`` says and hears, with Python's standard library alone.

It knows nothing of ROS. ``docs/protocol.md`` is the protocol; the numbers in brackets below are places in its tables.
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import select
import socket
import ssl
import struct
import threading
import urllib.parse
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

#: Version of the protocol that this client speaks.
VERSION = 3
MODEL, SNAPSHOT = 1, 2
ANGLES, LOST = 17, 18
LEFT, RIGHT = 0, 1
#: Parts of a hand, in the order of :attr:`Snapshot.loads`.
PARTS = ("palm", "thumb", "index", "middle", "ring", "little")


class ProtocolError(RuntimeError):
    """The server does not say what this client understands."""


class Contact(NamedTuple):
    """A contact that bears load."""

    #: Bodies A and B: places in the rigid bodies, or in the deformable ones plus 32768.
    bodies: tuple[int, int]
    #: Where, world [m].
    point: tuple[float, float, float]
    #: On A, world [N].
    force: tuple[float, float, float]


class Snapshot(NamedTuple):
    """The world after a step."""

    epoch: int
    number: int
    #: Simulated time [s].
    time: float
    #: Number of the newest pose that has acted.
    pose: int
    #: Rigid bodies: position [m], quaternion x, y, z, w.
    rigids: list[tuple[float, ...]]
    #: Nodes of the deformable bodies [m].
    nodes: list[tuple[float, ...]]
    #: For each hand, for palm, thumb, index, middle, ring, little: normal [N], shear [N], area [m²], pressure [Pa].
    loads: list[list[tuple[float, ...]]]
    contacts: list[Contact]


def read_model(message: bytes) -> tuple[int, dict[str, Any]]:
    """Epoch and description of the bodies; the arrays behind it are for who draws."""
    length = struct.unpack_from("<I", message, 8)[0]
    model: dict[str, Any] = json.loads(message[16 : 16 + length])
    return struct.unpack_from("<I", message, 4)[0], model


def read_snapshot(message: bytes) -> Snapshot:
    """A snapshot, table 2 of the protocol."""
    epoch, number = struct.unpack_from("<2I", message, 4)
    time = struct.unpack_from("<d", message, 16)[0]
    pose = struct.unpack_from("<I", message, 56)[0]
    rigids, nodes, targets, contacts, hands = struct.unpack_from("<5I", message, 64)
    at = 88

    def rows(count: int, width: int) -> list[tuple[float, ...]]:
        nonlocal at
        end = at + 4 * width * count
        found = list(struct.iter_unpack(f"<{width}f", message[at:end]))
        at = end
        return found

    placed, soft = rows(rigids, 7), rows(nodes, 3)
    rows(targets, 7)
    loads = rows(6 * hands, 4)
    found = []
    for k in range(contacts):
        a, b, _, _, *numbers = struct.unpack_from("<4H6f", message, at + 48 * k)
        found.append(Contact((a, b), tuple(numbers[:3]), tuple(numbers[3:])))
    if len(message) != at + 48 * contacts:
        raise ProtocolError(f"a snapshot of {len(message)} bytes, expected {at + 48 * contacts}")
    return Snapshot(
        epoch, number, time, pose, placed, soft, [loads[6 * k : 6 * k + 6] for k in range(hands)], found
    )


def angles_message(
    hand: int, number: int, clock: float, wrist: Sequence[float], angles: Sequence[float]
) -> bytes:
    """Pose message 17: where the wrist goes (7 numbers, world) and the twenty angles [rad]."""
    if len(wrist) != 7 or len(angles) != 20:
        raise ValueError(f"expected 7 numbers of the wrist and 20 angles, got {len(wrist)} and {len(angles)}")
    return struct.pack("<4BId27f", ANGLES, VERSION, hand, 0, number, clock, *wrist, *angles)


def _secure(plain: socket.socket, host: str, fingerprint: str) -> ssl.SSLSocket:
    """TLS with the server whose certificate has this SHA-256; nobody else vouches for it."""
    context = ssl.create_default_context()
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    try:
        secure = context.wrap_socket(plain, server_hostname=host)
    except BaseException:
        plain.close()
        raise
    found = hashlib.sha256(secure.getpeercert(binary_form=True) or b"").hexdigest().upper()
    if found != fingerprint.replace(":", "").strip().upper():
        secure.close()
        pairs = ":".join(found[k : k + 2] for k in range(0, len(found), 2))
        raise ProtocolError(f"another server is at {host}: its fingerprint is {pairs}")
    return secure


class Thenar:
    """A connection to ``thenar serve``: a small WebSocket client (RFC 6455)."""

    def __init__(
        self,
        host: str = "127.0.0.1",
        port: int = 8014,
        timeout: float = 10.0,
        *,
        token: str | None = None,
        fingerprint: str | None = None,
    ) -> None:
        """Connects; raises :class:`OSError`, or :class:`ProtocolError` where no Thenar of this version answers.

        ``token`` and ``fingerprint`` are those of ``thenar serve --lan``, see :meth:`at`.
        """
        self._socket = socket.create_connection((host, port), timeout)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if fingerprint is not None:
            self._socket = _secure(self._socket, host, fingerprint)
        self._timeout = timeout
        self._in = bytearray()
        # TLS takes one call at a time, and who listens is often another thread than who sends.
        self._lock = threading.Lock()
        self._poses = [0, 0]
        try:
            self._shake(f"[{host}]:{port}" if ":" in host else f"{host}:{port}", token)
            kind, welcome = self.receive()
            if kind != "text" or welcome.get("protocol") != VERSION:
                raise ProtocolError(f"expected protocol {VERSION}, got {welcome.get('protocol')}")
        except BaseException:
            self.close()
            raise
        #: Number of this client, by which ``status`` tells who is in control.
        self.client: int = welcome["client"]

    @classmethod
    def at(cls, address: str, fingerprint: str, timeout: float = 10.0) -> Thenar:
        """Connects to an address that ``thenar serve --lan`` prints, such as ``https://192.168.1.5:8014/?token=…``.

        ``fingerprint`` is printed below it. A server that has another one hears nothing of the token:
        :class:`ProtocolError`.
        """
        parts = urllib.parse.urlsplit(address)
        token = urllib.parse.parse_qs(parts.query).get("token", [""])[0]
        if parts.scheme != "https" or not parts.hostname or not token:
            raise ValueError(f"expected an address https://HOST:PORT/?token=…, got {address}")
        return cls(parts.hostname, parts.port or 443, timeout, token=token, fingerprint=fingerprint)

    def _shake(self, host: str, token: str | None) -> None:
        key = base64.b64encode(os.urandom(16)).decode()
        lines = [
            "GET /live HTTP/1.1" if token is None else f"GET /live?token={token} HTTP/1.1",
            f"Host: {host}",
            "Upgrade: websocket",
            "Connection: Upgrade",
            f"Sec-WebSocket-Key: {key}",
            "Sec-WebSocket-Version: 13",
        ]
        with self._lock:
            self._socket.sendall("\r\n".join([*lines, "", ""]).encode())
        while (end := self._in.find(b"\r\n\r\n")) < 0 and len(self._in) < 1 << 16:
            self._fill()
        status, *rest = self._read(end + 4 if end >= 0 else len(self._in)).decode("latin-1").split("\r\n")
        pairs = (line.partition(":") for line in rest)
        headers = {name.strip().lower(): value.strip() for name, _, value in pairs}
        digest = hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest()
        if " 101 " not in status or headers.get("sec-websocket-accept") != base64.b64encode(digest).decode():
            raise ProtocolError(f"no WebSocket at {host}: {status}")

    def _send(self, kind: int, data: bytes) -> None:
        mask = os.urandom(4)
        size = len(data)
        length = bytes([128 | size]) if size < 126 else bytes([128 | 126]) + struct.pack(">H", size)
        masked = bytes(byte ^ mask[k % 4] for k, byte in enumerate(data))
        with self._lock:
            self._socket.sendall(bytes([128 | kind]) + length + mask + masked)

    def _fill(self) -> None:
        with self._lock:
            ready = isinstance(self._socket, ssl.SSLSocket) and self._socket.pending() > 0
        if not ready and not select.select([self._socket], [], [], self._timeout)[0]:
            raise TimeoutError("thenar says nothing")
        with self._lock:
            data = self._socket.recv(1 << 16)
        if not data:
            raise ConnectionError("thenar has gone")
        self._in += data

    def _read(self, count: int) -> bytes:
        while len(self._in) < count:
            self._fill()
        data = bytes(self._in[:count])
        del self._in[:count]
        return data

    def receive(self) -> tuple[str, Any]:
        """The next message: ``("text", dict)``, ``("model", (epoch, dict))`` or ``("snapshot", Snapshot)``."""
        whole, first = b"", 0
        while True:
            head, size = self._read(2)
            size &= 127
            if size == 126:
                size = struct.unpack(">H", self._read(2))[0]
            elif size == 127:
                size = struct.unpack(">Q", self._read(8))[0]
            data = self._read(size)
            kind = head & 15
            if kind == 9:  # a ping is answered with what it carries
                self._send(10, data)
                continue
            if kind == 8:
                raise ConnectionError(f"thenar has closed: {data[2:].decode('utf-8', 'replace')}")
            if kind == 10:
                continue
            first = kind or first
            whole += data
            if head & 128:
                break
        if first == 1:
            return "text", json.loads(whole)
        if whole[1] != VERSION:
            raise ProtocolError(f"a message of protocol {whole[1]}, expected {VERSION}")
        if whole[0] == MODEL:
            return "model", read_model(whole)
        if whole[0] == SNAPSHOT:
            return "snapshot", read_snapshot(whole)
        raise ProtocolError(f"a message of kind {whole[0]}")

    def messages(self) -> Iterator[tuple[str, Any]]:
        """Messages, until the connection ends."""
        while True:
            yield self.receive()

    def command(self, **command: Any) -> None:
        """A command, such as ``command(type="run", paused=True)``."""
        self._send(1, json.dumps(command).encode())

    def follow(self, hand: int, clock: float, wrist: Sequence[float], angles: Sequence[float]) -> int:
        """Sends a pose of the left (0) or right (1) hand; returns its number, which comes back in a snapshot."""
        self._poses[hand] += 1
        self._send(2, angles_message(hand, self._poses[hand], clock, wrist, angles))
        return self._poses[hand]

    def lose(self, hand: int, clock: float) -> None:
        """The hand is not tracked any more."""
        self._poses[hand] += 1
        self._send(2, struct.pack("<4BId", LOST, VERSION, hand, 0, self._poses[hand], clock))

    def close(self) -> None:
        """Hangs up."""
        self._socket.close()

    def __enter__(self) -> Thenar:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
