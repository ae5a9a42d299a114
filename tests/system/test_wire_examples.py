"""Each byte example of the page on wires is sent as it stands there, and answered as it says."""

from __future__ import annotations

import hmac
import io
import json
import os
import re
import shutil
import socket
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import zenoh
from pagekit import ROOT, blocks
from serialkit import Cable

import rtkit
import rtkit.component
from rtkit.component.values.codec import codec_for
from rtkit.container.control_channel import ControlChannel
from rtkit.link import secret
from rtkit.link.zenoh import open_client, unix_endpoint
from rtkit.wires.http.digest import authorization, fields
from rtkit.wires.serve import ServedObject

PAGE = ROOT / "docs" / "wires.md"
BOUND_S = 20.0
KINDS = ("line", "login", "shared", "http", "control", "message", "data")


def examples(kind: str) -> list[str]:
    return [block.text for block in blocks(PAGE) if block.replay == kind]


def turns(text: str) -> Iterator[tuple[list[str], list[str]]]:
    """Yield the lines that are sent at a stretch, and those that come back."""
    sent: list[str] = []
    told: list[str] = []
    for line in text.splitlines():
        assert line[:1] in "<>", line
        if line[0] == ">" and told:
            yield sent, told
            sent, told = [], []
        (sent if line[0] == ">" else told).append(line[2:])
    yield sent, told


def assert_like(got: str, expected: str) -> None:
    """Compare, where … stands for anything."""
    pattern = ".*".join(map(re.escape, expected.split("…")))
    assert re.fullmatch(pattern, got), (got, expected)


def replay(stream: Any, text: str, words: Mapping[str, str]) -> None:
    """Send each line, and compare each that comes back; words stand for what differs."""
    for sent, told in turns(text):
        for line in sent:
            for word, meaning in words.items():
                line = line.replace(word, meaning)
            stream.write(f"{line}\n".encode())
        stream.flush()
        for line in told:
            assert_like(stream.readline().decode().removesuffix("\n"), line)


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ServedObject]:
    """The object of the page, with all its endpoints."""
    for name in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        folder = tmp_path / name[6:9]
        folder.mkdir(mode=0o700)
        monkeypatch.setenv(name, str(folder))
    (source,) = [block.text for block in blocks(PAGE) if block.file == "robot.py"]
    names: dict[str, Any] = {"__name__": "robot"}
    exec(source, names)
    with rtkit.serve(names["Robot"](), "robot", port=0, http=0, is_on_zenoh=False) as served:
        yield served


def test_every_kind_has_examples() -> None:
    found = {block.replay for block in blocks(PAGE)} - {""}
    assert found == set(KINDS)


def test_lines(robot: ServedObject) -> None:
    with socket.socket(socket.AF_UNIX) as end:
        end.settimeout(BOUND_S)
        end.connect(robot.socket)
        with end.makefile("rwb") as stream:
            for text in examples("line"):
                replay(stream, text, {})


def test_the_login_over_tcp(robot: ServedObject) -> None:
    assert robot.port is not None
    user, password = secret.read()
    (text,) = examples("login")
    end = socket.create_connection(("127.0.0.1", robot.port), BOUND_S)
    with end, end.makefile("rwb") as stream:
        stream.write(b"GET door/nonce\n")
        stream.flush()
        nonce = stream.readline().decode().removeprefix("= ").strip()
        proof = hmac.new(password.encode(), nonce.encode(), "sha256").hexdigest()
        replay(stream, text.replace("NONCE", nonce), {"PROOF": proof, "USER": user})


def test_lines_that_devices_share(tmp_path: Path, robot: ServedObject) -> None:
    cable = Cable(str(tmp_path))
    opening = {"serial": f"{cable.far}?address=7", "settable": ["*"], "is_on_zenoh": False}
    try:
        with (
            rtkit.serve(robot.service, "device", **opening),  # type: ignore[arg-type]
            open(cable.near, "r+b", buffering=0) as end,
            io.BufferedRWPair(end, end) as stream,
        ):
            for text in examples("shared"):
                replay(stream, text, {"␐": "\x10"})
    finally:
        cable.close()


@pytest.mark.skipif(shutil.which("node") is None, reason="there is no node")
@pytest.mark.parametrize("words", [[], ["unix:x"], ["unix:x", "set", "speed"], ["unix:x", "put"]])
def test_the_client_in_node_tells_its_usage(words: list[str]) -> None:
    client = ROOT / "examples" / "wires" / "client.js"
    done = subprocess.run(
        ["node", client, *words], capture_output=True, text=True, timeout=BOUND_S, check=False
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("usage: node client.js ADDRESS list | get NAME")
    assert f" in {len(client.read_text().splitlines())} lines " in PAGE.read_text()


def test_http(robot: ServedObject) -> None:
    assert robot.http is not None
    for text in examples("http"):
        ((sent, told),) = turns(text)
        method, path, _ = sent[0].split(" ")
        words = {"PORT": str(robot.http)}
        if any("DIGEST" in line for line in sent):
            words["DIGEST"] = authorization(secret.read(), method, path, _nonce(robot), 1, "mine")
        request = "\r\n".join(sent) + "\r\n"
        for word, meaning in words.items():
            request = request.replace(word, meaning)
        with socket.create_connection(("127.0.0.1", robot.http), BOUND_S) as end:
            end.sendall(request.encode())
            with end.makefile("rb") as stream:
                check_http(stream, *split(told))


def split(told: list[str]) -> tuple[str, list[str], list[str]]:
    """Part an answer into its first line, headers and body."""
    head, *rest = told
    at = rest.index("") if "" in rest else len(rest)
    return head, rest[:at], rest[at + 1 :]


def check_http(stream: Any, head: str, headers: list[str], body: list[str]) -> None:
    """Compare an answer; of its headers only those that are told."""
    assert_like(_line(stream), head)
    got = list(iter(lambda: _line(stream), ""))
    for each in headers:
        name = each.partition(":")[0] + ":"
        assert_like(next(one for one in got if one.startswith(name)), each)
    length = next((one.partition(": ")[2] for one in got if one.startswith("Content-Length")), "")
    if length and body:
        assert_like(stream.read(int(length)).decode(), "\n".join(body))
        return
    for each in filter(None, body):
        while not (line := _line(stream)) or re.fullmatch("[0-9a-f]+", line):
            pass  # the size of a piece, or what ends one
        assert_like(line, each)


def _line(stream: Any) -> str:
    return bytes(stream.readline()).decode().rstrip("\r\n")


def _nonce(robot: ServedObject) -> str:
    with socket.create_connection(("127.0.0.1", robot.http or 0), BOUND_S) as end:
        end.sendall(b"GET /ps/robot/speed HTTP/1.1\r\nHost: localhost:%d\r\n\r\n" % robot.http)
        with end.makefile("rb") as stream:
            while not (line := _line(stream)).startswith("WWW-Authenticate:"):
                pass
    return fields(line.partition(": ")[2])["nonce"]


def test_control(manager: Any) -> None:
    path = f"{manager.environment['RTKIT_RUNTIME_DIR']}/manager.sock"
    host = os.uname().nodename
    session = open_client(unix_endpoint(path), BOUND_S)
    try:
        for text in examples("control"):
            for (sent,), (told,) in turns(text):
                key, _, payload = sent.partition(" ")
                key = key.replace("KEY", f"rt/default/{host}/manager")
                got = _asked(session, key, payload)
                assert_like(got, told.replace("HOST", host))
    finally:
        session.close()  # type: ignore[no-untyped-call]


def _asked(session: zenoh.Session, key: str, payload: str) -> str:
    (reply,) = session.get(key, payload=payload or None, timeout=BOUND_S)
    if reply.ok is not None:
        return reply.ok.payload.to_string()
    assert reply.err is not None
    return f"! {reply.err.payload.to_string()}"


def test_messages_of_slaves() -> None:
    for text in examples("message"):
        message, told = text.splitlines()
        one, other = socket.socketpair()
        with one, other:
            ControlChannel(one).send(json.loads(message))
            assert other.recv(4096) == bytes.fromhex(told)


def test_values_of_ports() -> None:
    names = {name: getattr(rtkit.component, name) for name in rtkit.component.__all__}
    for text in examples("data"):
        for example in text.split("\n\n"):
            expression, told = example.strip().splitlines()
            value = eval(expression, names)
            codec = codec_for(type(value))
            assert bytes(codec.encode(value)) == bytes.fromhex(told)
            assert codec.decode(bytes.fromhex(told)) == value
