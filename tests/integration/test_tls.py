"""Endpoints with mutual TLS: who comes in, who does not, and that the endpoint lives on."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import socket
import ssl
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from conformance import subject
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID
from waiting import until

from rtkit import Client, Word
from rtkit.errors import NotFound, Refused, RtkitError, Unreachable
from rtkit.keys import audit, authority, folder
from rtkit.property.codes import PropertyError
from rtkit.services.resource import Resource
from rtkit.wires import secure
from rtkit.wires.http.client import HttpClient
from rtkit.wires.http.secure import connect_https
from rtkit.wires.line.client import LineClient
from rtkit.wires.line.secure import connect_tcps
from rtkit.wires.serve import ServedObject, serve

BOUND_S = 20.0
RULES = "allow * helper SET count\ndeny * anna GET name"
WIRES = {"tcps": "tls", "https": "https"}


@pytest.fixture
def own(place: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """A CA of this test alone."""
    monkeypatch.setenv("RTKIT_KEYS", f"{place}/keys")
    authority.init("owner1", ["localhost", "127.0.0.1"])
    return f"{place}/keys"


@pytest.fixture(params=WIRES)
def served(own: str, request: pytest.FixtureRequest) -> Iterator[ServedObject]:
    """Each wire behind TLS."""
    more = {WIRES[request.param]: "127.0.0.1:0"}
    with serve(subject(), "robot", is_on_zenoh=False, rules=RULES, **more) as served:
        yield served


def _is_https(served: ServedObject) -> bool:
    return "https" in served.addresses


def _port(served: ServedObject) -> int:
    (address,) = served.addresses.values()
    return int(address.partition("localhost:")[2].partition("/")[0])


def _connected(
    served: ServedObject, host: str = "localhost", port: int = 0
) -> LineClient | HttpClient:
    port = port or _port(served)
    if _is_https(served):
        client = connect_https(f"https://{host}:{port}", BOUND_S)
        try:
            client.ask("robot/speed").value()
        except BaseException:
            client.close()
            raise
        return client
    return connect_tcps(host, port, BOUND_S)


def _handed(own: str, name: str, role: str, days: int = 30) -> str:
    authority.issue(name, role, [], days, f"{own}.{name}")
    return f"{own}.{name}"


@contextlib.contextmanager
def _as(keys: str, served: ServedObject) -> Iterator[LineClient | HttpClient]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", keys)
        client = _connected(served)
    with client:
        yield client


def _is_alive(own: str, served: ServedObject) -> bool:
    with _as(own, served) as client:
        return client.ask("robot/count").payload == "7"


def test_roles_and_rules_say_what_a_certificate_may(own: str, served: ServedObject) -> None:
    """The name of the certificate is who it is in rules; without one a component only looks."""
    who = {name: _handed(own, name, role) for name, role in (
        ("anna", "viewer"), ("bert", "operator"), ("helper", "component"), ("other", "component"),
    )}  # fmt: skip
    answers = {}
    for name, keys in who.items():
        with _as(keys, served) as client:
            if not _is_https(served):
                assert client.ask("door/identity").payload == name
            answers[name] = [client.ask("robot/count").error, client.ask("robot/name").error,
                             client.ask("robot/count", "8").error]  # fmt: skip
    assert answers == {
        "anna": ["", "denied", "denied"],
        "bert": ["", "", ""],
        "helper": ["", "", ""],
        "other": ["", "", "denied"],
    }


def test_what_others_set_is_on_record(own: str, served: ServedObject) -> None:
    with _as(_handed(own, "anna", "viewer"), served) as client:
        client.ask("robot/count", "9")
        client.ask("robot/name")
    with _as(own, served) as client:
        client.ask("robot/count", "9")
        client.ask("robot/password", "hunter2")
        client.ask("robot/count")
    text = Path(audit.file()).read_text(encoding="utf-8")
    lines = [json.loads(line) for line in text.splitlines()]
    assert [(each["name"], each["role"], each["what"], each["result"].split(":")[0])
            for each in lines] == [
        ("anna", "viewer", "SET robot.count", "denied"),
        ("anna", "viewer", "GET robot.name", "denied"),
        ("owner1", "administrator", "SET robot.count", "done"),
        ("owner1", "administrator", "SET robot.password", "unknown"),
    ]  # fmt: skip
    assert {each["address"] for each in lines} == {"127.0.0.1"}
    assert "hunter2" not in text
    assert os.stat(audit.file()).st_mode & 0o777 == 0o600


def test_without_a_record_the_endpoint_lives_on(
    own: str, served: ServedObject, caplog: pytest.LogCaptureFixture
) -> None:
    os.mkdir(audit.file())
    with _as(own, served) as client:
        assert client.ask("robot/count", "9").error == ""
        assert client.ask("robot/count").payload == "9"
    assert "no record of SET robot.count" in caplog.text


def test_the_record_is_bounded(
    own: str, served: ServedObject, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(audit, "MOST_BYTES", 2000)
    with _as(own, served) as client:
        for number in range(50):
            client.ask("robot/count", str(number % 5))
    assert sorted(os.listdir(os.path.dirname(audit.file()))) == ["audit.jsonl", "audit.jsonl.1"]
    assert os.stat(f"{audit.file()}.1").st_size < 3000


def test_who_is_revoked_is_cut_and_comes_in_no_more(own: str, served: ServedObject) -> None:
    keys = _handed(own, "bert", "operator")
    with _as(keys, served) as client:
        with pytest.MonkeyPatch.context() as patch:  # for a stream has a connection of its own
            patch.setenv("RTKIT_KEYS", keys)
            client.listen("robot/count")
        authority.revoke("bert")
        begin = time.monotonic()
        with pytest.raises(Unreachable, match="ended"):
            list(iter(lambda: client.event(BOUND_S), None))
        took_s = time.monotonic() - begin
    with pytest.raises(PropertyError, match="revoked") as raised, _as(keys, served):
        pass
    assert raised.value.code == "denied"
    assert took_s < 10, took_s  # promised is one second
    assert _is_alive(own, served)


def test_a_list_of_the_revoked_that_cannot_be_read_lets_nobody_in(
    own: str, served: ServedObject
) -> None:
    kept = Path(own, folder.REVOKED).read_bytes()
    Path(own, folder.REVOKED).write_bytes(b"rubbish")
    other = _handed_by_stranger(own)
    for each in (own, other):
        with pytest.raises(RtkitError), _as(each, served):
            pass
    Path(own, folder.REVOKED).write_bytes(kept)
    until(lambda: _is_alive(own, served), "it goes on with a list that can be read")


def _handed_by_stranger(own: str) -> str:
    """Return keys of another CA, which are good there."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", f"{own}.stranger")
        authority.init("bert", ["localhost"])
    shutil.copy(f"{own}/{folder.CA_CERTIFICATE}", f"{own}.stranger")
    return f"{own}.stranger"


def _forged(
    own: str, begins_h: float, ends_h: float, uri: str, *, is_self_signed: bool = False
) -> str:
    """Return keys that the CA would not issue: valid from and to so many hours from now."""
    place = f"{own}.forged"
    shutil.copytree(own, place)
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "bert")])
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", own)
        ca, signer = authority._authority()
    now = datetime.now(UTC)
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name if is_self_signed else ca.subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now + timedelta(hours=begins_h))
        .not_valid_after(now + timedelta(hours=ends_h))
        .add_extension(x509.SubjectAlternativeName([x509.UniformResourceIdentifier(uri)]), False)
        .sign(key if is_self_signed else signer, hashes.SHA256())
    )
    pem = serialization.Encoding.PEM
    Path(place, folder.CERTIFICATE).write_bytes(made.public_bytes(pem))
    Path(place, folder.KEY).write_bytes(key.private_bytes(
        pem, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()))  # fmt: skip
    return place


OPERATOR = "rtkit:role:operator"
BAD: dict[str, tuple[Callable[[str], str], str]] = {
    "expired": (lambda own: _forged(own, -2, -1, OPERATOR), "expired"),
    "not-yet": (lambda own: _forged(own, 1, 2, OPERATOR), ""),
    "no-role": (lambda own: _forged(own, -1, 1, "rtkit:other"), "role"),
    "odd-role": (lambda own: _forged(own, -1, 1, "rtkit:role:king"), "role"),
    "self-signed": (lambda own: _forged(own, -1, 1, OPERATOR, is_self_signed=True), ""),
    "wrong-ca": (_handed_by_stranger, ""),
}


@pytest.mark.parametrize("kind", BAD)
def test_bad_certificates_are_denied(own: str, served: ServedObject, kind: str) -> None:
    make, why = BAD[kind]
    keys = make(own)
    if kind == "wrong-ca":  # a client that trusts this CA, but is of another one
        shutil.copy(f"{own}/{folder.REVOKED}", keys)
    with pytest.raises((PropertyError, Unreachable)) as raised, _as(keys, served):
        pass
    assert why in str(raised.value)
    assert getattr(raised.value, "code", "denied") == "denied"
    assert _is_alive(own, served)


def test_a_server_of_another_ca_or_name_is_not_trusted(own: str, served: ServedObject) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", f"{own}.2")
        authority.init("mallory", ["localhost"])
        with pytest.raises(PropertyError, match="not trusted"):
            _connected(served)
    with pytest.raises(PropertyError, match="not valid for"):
        _at_other_name(served)


class _Between:
    """Stands between client and endpoint: keeps what the client sends, and changes one bit of it.

    Args:
        port: Of the endpoint.
        changes: Which piece of the client is changed; 0 for none.
    """

    def __init__(self, port: int, changes: int) -> None:
        self.kept: list[bytes] = []
        self._ends = [socket.create_server(("127.0.0.1", 0))]
        self.port = int(self._ends[0].getsockname()[1])
        threading.Thread(target=self._serve, args=(port, changes), daemon=True).start()

    def _serve(self, port: int, changes: int) -> None:
        near, _ = self._ends[0].accept()
        far = socket.create_connection(("127.0.0.1", port))
        self._ends += [near, far]
        threading.Thread(target=self._pass, args=(far, near, [], 0), daemon=True).start()
        self._pass(near, far, self.kept, changes)

    @staticmethod
    def _pass(source: socket.socket, sink: socket.socket, kept: list[bytes], changes: int) -> None:
        with contextlib.suppress(OSError):
            while piece := source.recv(1 << 16):
                kept.append(piece)
                if len(kept) == changes:
                    piece = piece[:-1] + bytes([piece[-1] ^ 1])
                sink.sendall(piece)
        for end in (source, sink):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        for end in self._ends:
            end.close()


def test_what_is_changed_or_sent_again_does_nothing(own: str, served: ServedObject) -> None:
    with (
        contextlib.closing(_Between(_port(served), 0)) as between,
        _connected(served, "127.0.0.1", between.port) as client,
    ):
        assert client.ask("robot/count", "9").error == ""
        kept = [*between.kept]
    with _as(own, served) as client:
        assert client.ask("robot/count", "7").error == ""
    done = _record()
    with (
        socket.create_connection(("127.0.0.1", _port(served)), BOUND_S) as end,
        contextlib.suppress(OSError),
    ):
        for piece in kept:
            end.sendall(piece)
        end.shutdown(socket.SHUT_WR)
        while end.recv(1 << 16):
            pass
    assert _is_alive(own, served)
    for changes in range(1, len(kept) + 1):
        with contextlib.closing(_Between(_port(served), changes)) as between:
            try:
                with _connected(served, "127.0.0.1", between.port) as client:
                    answer = client.ask("robot/count", "7").error
            except (RtkitError, OSError):
                answer = "ended"
            # Pieces come together at times: then it was never changed, and is done.
            assert bool(answer) == (len(between.kept) >= changes), changes
        done += [*done[-1:]] * (not answer)
    assert _is_alive(own, served)
    assert len(_record()) == len(done)


def _record() -> list[str]:
    return Path(audit.file()).read_text(encoding="utf-8").splitlines()


def test_a_host_is_added_by_a_certificate_that_names_it_too(
    own: str, served: ServedObject, tmp_path: Path
) -> None:
    with pytest.raises(PropertyError, match="--host robot9 makes one that is"):
        _at_other_name(served)
    made = tmp_path / "more.keys"
    authority.issue("owner1", "administrator", ["localhost", "robot9"], 30, str(made))
    for name in (folder.KEY, folder.CERTIFICATE):
        shutil.copy(made / name, own)
    _at_other_name(served)


def test_a_server_that_is_revoked_is_not_trusted(own: str, served: ServedObject) -> None:
    keys = _handed(own, "anna", "viewer")
    authority.revoke("owner1")
    with _as(keys, served) as client:  # nobody has told anna
        assert client.ask("robot/count").payload == "7"
    shutil.copy(f"{own}/{folder.REVOKED}", keys)
    with (
        pytest.raises(PropertyError, match="is not trusted: certificate revoked"),
        _as(keys, served),
    ):
        pass


@pytest.mark.parametrize("how", ["cut", "empty", "forged", "absent"])
def test_a_client_trusts_nobody_without_a_good_list_of_the_revoked(
    own: str, served: ServedObject, how: str
) -> None:
    keys = _handed(own, "anna", "viewer")
    listed = Path(keys, folder.REVOKED)
    if how == "forged":
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("RTKIT_KEYS", f"{own}.2")
            authority.init("owner1", ["localhost"])
        shutil.copy(f"{own}.2/{folder.REVOKED}", listed)
    elif how == "absent":
        listed.unlink()
    else:
        listed.write_bytes(listed.read_bytes()[:-100] if how == "cut" else b"")
    with pytest.raises(RtkitError) as raised, _as(keys, served):
        pass
    assert not isinstance(raised.value, Unreachable), raised.value
    assert _is_alive(own, served)


def _at_other_name(served: ServedObject) -> None:
    with pytest.MonkeyPatch.context() as patch:
        real = socket.create_connection
        patch.setattr(
            socket, "create_connection", lambda at, *more: real(("127.0.0.1", at[1]), *more)
        )
        _connected(served, "robot9").close()


def _raw(served: ServedObject) -> socket.socket:
    end = socket.create_connection(("127.0.0.1", _port(served)), BOUND_S)
    end.settimeout(BOUND_S)
    return end


def _ends(end: socket.socket) -> bool:
    with contextlib.suppress(ConnectionError):
        while end.recv(4096):
            pass
    return True


SAID = {
    "lines": b"GET count\n",
    "http": b"GET / HTTP/1.1\r\n\r\n",
    "long": b"\x16\x03\x01\xff\xff" + bytes(70000),
    "rubbish": b"\xa5" * 5000,
}


@pytest.mark.parametrize("said", SAID.values(), ids=SAID)
def test_plain_text_at_the_tls_port_is_hung_up_on(
    own: str, served: ServedObject, said: bytes
) -> None:
    with _raw(served) as end:
        with contextlib.suppress(OSError):
            end.sendall(said)
            end.shutdown(socket.SHUT_WR)
        assert _ends(end)
    assert _is_alive(own, served)


def test_no_certificate_is_denied(own: str, served: ServedObject) -> None:
    context = ssl.create_default_context(cafile=f"{own}/{folder.CA_CERTIFICATE}")
    with (
        context.wrap_socket(_raw(served), server_hostname="localhost") as tls,
        pytest.raises((ssl.SSLError, ConnectionError)),
    ):
        _asked(tls)
    assert _is_alive(own, served)


def _asked(tls: ssl.SSLSocket) -> bytes:
    tls.sendall(b"GET count\n")
    return tls.recv(100)


def test_half_open_handshakes_never_keep_the_owner_out(
    own: str, served: ServedObject, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There is room for 512 clients; who has not shown a certificate makes room, and is ended."""
    with contextlib.ExitStack() as ends:
        held = [ends.enter_context(_raw(served)) for _ in range(600)]
        assert _is_alive(own, served)
        monkeypatch.setattr(secure, "PATIENCE_S", 0.0)
        assert all(map(_ends, held))
    assert _is_alive(own, served)


def test_tls_at_the_plain_port_is_an_error_and_no_more(own: str) -> None:
    with serve(subject(), "plain", is_on_zenoh=False, port=0) as served:
        with pytest.raises(Unreachable, match="no TLS with"):
            connect_tcps("localhost", int(str(served.port)), BOUND_S)
        assert served.port is not None


@pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl command")
@pytest.mark.parametrize("options", [["-tls1_2"], ["-tls1_1"], ["-no_tls1_3"], ["-cert", "BIG"]])
def test_what_openssl_tries(
    own: str, served: ServedObject, options: list[str], tmp_path: Path
) -> None:
    """Old versions, of which one can renegotiate, and a chain that is too long are refused."""
    keys = _handed(own, "bert", "operator")
    big = tmp_path / "big.pem"
    leaf = Path(keys, folder.CERTIFICATE).read_text(encoding="ascii")
    big.write_text(leaf + Path(own, folder.CA_CERTIFICATE).read_text(encoding="ascii") * 2000)
    more = [each.replace("BIG", f"{keys}/{folder.CERTIFICATE}") for each in options]
    if "BIG" in options:
        more += ["-cert_chain", str(big)]
    line = ["openssl", "s_client", "-connect", f"127.0.0.1:{_port(served)}", "-quiet",
            "-key", f"{keys}/{folder.KEY}", "-cert", f"{keys}/{folder.CERTIFICATE}"]  # fmt: skip
    asked = ASKED[_is_https(served)]
    assert _answered(line, asked).split()[:2] in ([b"=", b"7"], [b"HTTP/1.1", b"200"])
    assert _answered([*line, *more], asked) == b""
    assert _is_alive(own, served)


ASKED = (b"GET count\n", b"GET /ps/robot/count HTTP/1.1\r\nHost: localhost\r\n\r\n")


def _answered(line: list[str], asked: bytes) -> bytes:
    """Return what the endpoint answers before it, or openssl, hangs up."""
    pipe = subprocess.PIPE
    with subprocess.Popen(line, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL) as client:
        assert client.stdin is not None
        assert client.stdout is not None
        with contextlib.suppress(BrokenPipeError):
            client.stdin.write(asked)
            client.stdin.flush()
        answer = client.stdout.readline()
        client.kill()
        with contextlib.suppress(BrokenPipeError):
            client.stdin.close()
    return answer


def test_keys_that_others_can_read_serve_nobody(own: str) -> None:
    os.chmod(f"{own}/{folder.KEY}", 0o640)
    with pytest.raises(Refused, match="others can read it"):
        serve(subject(), "robot", is_on_zenoh=False, tls="0")
    os.unlink(f"{own}/{folder.KEY}")
    with pytest.raises(NotFound, match="rtkeys"):
        serve(subject(), "robot", is_on_zenoh=False, tls="0")


def test_a_resource_service_finds_and_reaches_who_is_behind_tls(served: ServedObject) -> None:
    scheme = "https" if _is_https(served) else "tcps"
    contact = f'<contact protocol="{scheme}">localhost:{_port(served)}</contact>'
    registry = serve(Resource(watch="", route=True), "resource", is_on_zenoh=False)
    with registry, Client(BOUND_S) as client:
        client.set("resource.robot", Word(f'<service type="arm">{contact}</service>'))
        assert client.get("resource.search", where="count == 7") == ("robot",)
        assert client.get("resource.search", where="count == 8") == ()
        assert client.get("resource.robot.count") == 7
