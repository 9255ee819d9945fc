"""Goal: the socket halves of the clients for ROS 2 and Unity speak with the real server, on this computer and as from
another one. Method: `thenar serve` without and with `--lan`, led by each; the wrist goes where it is told to, and
figures agree with the model; a wrong token and a wrong fingerprint are refused."""

import json
import pathlib
import re
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import NamedTuple

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "examples/clients/ros2"))
import thenar_socket  # noqa: E402

UNITY = ROOT / "examples/clients/unity"


class Lan(NamedTuple):
    """What a server with ``--lan`` prints."""

    address: str
    fingerprint: str


def free_port() -> int:
    """A port that nobody has."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def command(program: pathlib.Path, port: int) -> list[str]:
    """Serves a hand in free air."""
    return [str(program), "serve", "table-press", "--no-open", "--port", str(port), "--set", 'hand.0.preset="paper"']


@pytest.fixture
def lan(program: pathlib.Path) -> Iterator[Lan]:
    """A server that lets other computers in."""
    arguments = [*command(program, free_port()), "--lan"]
    serving = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True, encoding="utf-8")
    assert serving.stdout is not None
    try:
        address = ""
        for line in serving.stdout:
            address = address or (re.findall(r"https://\S+", line) or [""])[0]
            if re.fullmatch(r"\s*([0-9A-F]{2}:){31}[0-9A-F]{2}\s*", line):
                break
        else:
            raise AssertionError("no fingerprint was printed")
        yield Lan(address, line.strip())
    finally:
        serving.terminate()
        serving.wait(20)
        serving.stdout.close()


@pytest.fixture
def server(program: pathlib.Path) -> Iterator[int]:
    """The port of a server that shows a hand in free air."""
    port = free_port()
    serving = subprocess.Popen(command(program, port), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        for _ in range(300):
            try:
                socket.create_connection(("127.0.0.1", port), 1).close()
                break
            except OSError:
                assert serving.poll() is None, "the server has ended"
                try:
                    serving.wait(0.1)
                except subprocess.TimeoutExpired:
                    pass
        yield port
    finally:
        serving.terminate()
        serving.wait(20)


def test_the_client_of_ros_2_leads_a_hand_and_reads_forces(server: int) -> None:
    leads_and_reads(lambda: thenar_socket.Thenar(port=server))


def test_the_client_of_ros_2_does_so_from_another_computer(lan: Lan) -> None:
    leads_and_reads(lambda: thenar_socket.Thenar.at(*lan))


def leads_and_reads(connect: Callable[[], thenar_socket.Thenar]) -> None:
    """Leads the hand onto the table."""
    with connect() as thenar:
        model = next(message for kind, message in thenar.messages() if kind == "model")[1]
        hand = model["hands"][0]
        bone = hand["bone_start"]
        begin = next(message for kind, message in thenar.messages() if kind == "snapshot")
        assert len(begin.rigids) == len(model["rigids"]) and len(begin.loads) == 1 and len(begin.loads[0]) == 6
        assert len(begin.nodes) == sum(soft["nodes"]["count"] for soft in model["softs"])
        # The palm of the scene's right hand goes down until it presses: the table is 0.1 m below at most.
        wrist = list(begin.rigids[bone])
        height, sent, pressed, seen = wrist[1], 0, 0.0, begin
        for kind, message in thenar.messages():
            if kind != "snapshot":
                continue
            seen = message
            pressed = sum(part[0] for part in seen.loads[0])
            if pressed > 2.0 and seen.pose > 0:
                break
            wrist[1] = max(wrist[1] - 0.002, height - 0.09)
            sent = thenar.follow(thenar_socket.RIGHT, seen.time, wrist, [0.0] * 20)
            assert sent < 3000, f"{pressed} N after {sent} poses"
        assert 0 < seen.pose <= sent and seen.rigids[bone][1] < height - 0.02
        # Contacts of the same snapshot: the table is held down as hard as it holds the hand up.
        up = sum(contact.force[1] * (1 if contact.bodies[0] >= 32768 else -1) for contact in seen.contacts)
        assert up == pytest.approx(pressed, rel=0.25)
        # What makes no sense is refused in words.
        thenar.command(type="set", key="frction", value=1.0)
        texts = (message for kind, message in thenar.messages() if kind == "text")
        assert "frction" in next(text for text in texts if text["type"] == "error")["message"]


def without_its_token(lan: Lan) -> str:
    """The address with a guess in the token's place."""
    return re.sub(r"token=.*", f"token={'0' * 32}", lan.address)


def test_a_stranger_hears_no_token_and_a_wrong_token_is_refused(lan: Lan) -> None:
    stranger = "00" + lan.fingerprint[2:] if lan.fingerprint[:2] != "00" else "01" + lan.fingerprint[2:]
    with pytest.raises(thenar_socket.ProtocolError, match=f"its fingerprint is {lan.fingerprint}"):
        thenar_socket.Thenar.at(lan.address, stranger)
    with pytest.raises(thenar_socket.ProtocolError, match="no WebSocket at .*403"):
        thenar_socket.Thenar.at(without_its_token(lan), lan.fingerprint)
    for address in (lan.address.replace("https", "http"), lan.address.partition("?")[0], "https://?token=1"):
        with pytest.raises(ValueError, match="expected an address"):
            thenar_socket.Thenar.at(address, lan.fingerprint)
    # As it is printed, or as other programs write it.
    thenar_socket.Thenar.at(lan.address, lan.fingerprint.replace(":", "").lower()).close()


def test_what_is_no_server_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = int(listening.getsockname()[1])
        # Whoever answers with something else: here nobody answers at all.
        with pytest.raises((thenar_socket.ProtocolError, OSError)):
            thenar_socket.Thenar(port=port, timeout=0.2)
    with pytest.raises(ValueError, match="20 angles"):
        thenar_socket.angles_message(1, 1, 0.0, [0.0] * 7, [0.0] * 19)


@pytest.fixture
def probe(tmp_path: pathlib.Path) -> list[str]:
    """The client of Unity with its trial, which is told where the hand's bones begin and where the server is."""
    compiler, runtime = shutil.which("mcs"), shutil.which("mono")
    if compiler is None or runtime is None:
        pytest.skip("there is no Mono: mono-mcs and mono-runtime of Debian have it")
    probe = tmp_path / "probe.exe"
    sources = [UNITY / "Probe.cs", UNITY / "ThenarClient.cs"]
    subprocess.run([compiler, "-warnaserror", "-r:System.dll", f"-out:{probe}", *sources], check=True)
    return [runtime, str(probe), "1"]


def tried(command: list[str]) -> tuple[int, str]:
    """What became of the trial, and what it said."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        out, _ = running.communicate(timeout=90)
    return running.returncode, out


def test_the_client_of_unity_leads_a_hand_and_reads_forces(server: int, probe: list[str]) -> None:
    # The first client to come has control: it is the one that is tried.
    led(*tried([*probe, str(server)]))


def test_the_client_of_unity_does_so_from_another_computer(lan: Lan, probe: list[str]) -> None:
    stranger = lan.fingerprint[:-2] + ("00" if lan.fingerprint[-2:] != "00" else "01")
    code, out = tried([*probe, lan.address, stranger])
    assert code == 2 and out.startswith("no connection"), out
    code, out = tried([*probe, without_its_token(lan), lan.fingerprint])
    assert code == 2 and "no WebSocket at" in out and " 403 " in out, out
    led(*tried([*probe, *lan]))


def led(code: int, out: str) -> None:
    """Figures of a trial that went well."""
    told = dict(line.split(" ", 1) for line in out.splitlines())
    assert code == 0, out
    length, has_bones = told["model"].split()
    assert int(length) > 1000 and has_bones == "True"
    assert 0.019 < float(told["rose"]) < 0.035 and told["pose"] == "True True"
    assert told["bodies"] == "17 24"
    refused = json.loads(told["refused"])
    assert refused["type"] == "error" and "frction" in refused["message"]
