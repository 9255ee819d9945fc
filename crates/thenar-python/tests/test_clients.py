"""Goal: the socket halves of the clients for ROS 2 and Unity speak with the real server. Method: `thenar serve`, led by
each; the wrist goes where it is told to, and figures agree with the model."""

import json
import pathlib
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "examples/clients/ros2"))
import thenar_socket  # noqa: E402

UNITY = ROOT / "examples/clients/unity"


@pytest.fixture
def server(program: pathlib.Path) -> Iterator[int]:
    """The port of a server that shows a hand in free air."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = int(free.getsockname()[1])
    command = [str(program), "serve", "table-press", "--no-open", "--port", str(port), "--set", 'hand.0.preset="paper"']
    serving = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
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
    with thenar_socket.Thenar(port=server) as thenar:
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


def test_what_is_no_server_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = int(listening.getsockname()[1])
        # Whoever answers with something else: here nobody answers at all.
        with pytest.raises((thenar_socket.ProtocolError, OSError)):
            thenar_socket.Thenar(port=port, timeout=0.2)
    with pytest.raises(ValueError, match="20 angles"):
        thenar_socket.angles_message(1, 1, 0.0, [0.0] * 7, [0.0] * 19)


def test_the_client_of_unity_leads_a_hand_and_reads_forces(server: int, tmp_path: pathlib.Path) -> None:
    compiler, runtime = shutil.which("mcs"), shutil.which("mono")
    if compiler is None or runtime is None:
        pytest.skip("there is no Mono: mono-mcs and mono-runtime of Debian have it")
    probe = tmp_path / "probe.exe"
    sources = [UNITY / "Probe.cs", UNITY / "ThenarClient.cs"]
    subprocess.run([compiler, "-warnaserror", "-r:System.dll", f"-out:{probe}", *sources], check=True)
    # The first client to come has control: it is the one that is tried. It is told where the hand's bones begin.
    with subprocess.Popen([runtime, probe, str(server), "1"], stdout=subprocess.PIPE, text=True) as running:
        out, _ = running.communicate(timeout=90)
    told = dict(line.split(" ", 1) for line in out.splitlines())
    assert running.returncode == 0, out
    length, has_bones = told["model"].split()
    assert int(length) > 1000 and has_bones == "True"
    assert 0.019 < float(told["rose"]) < 0.035 and told["pose"] == "True True"
    assert told["bodies"] == "17 24"
    refused = json.loads(told["refused"])
    assert refused["type"] == "error" and "frction" in refused["message"]
