"""Storage: files as properties, whole or not at all, and nothing outside of its directory."""

from __future__ import annotations

import hashlib
import os
import random
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from queue import SimpleQueue

import pytest

import rtkit
from rtkit import PropertyError
from rtkit.property.objects import Exported
from rtkit.property.service import Service
from rtkit.services.paths import TEMPORARY
from rtkit.services.storage import BLOCK, Storage

MIB = 1 << 20
SECRET = b"root:x:0:0"


class Files(Service):
    """Storage as others see it."""

    def __init__(self, root: Path, **settings: object) -> None:
        super().__init__()
        self.storage = Storage(str(root), synced=False, **settings)  # type: ignore[arg-type]
        Exported(self, self.storage)

    def code(self, target: str, payload: bytes | None = None) -> str:
        """Return the code of a refusal, which tells nothing of where files are."""
        with pytest.raises(PropertyError) as caught:
            self.get(target) if payload is None else self.set(target, payload)
        assert "/" not in str(caught.value).replace("x/y", "")
        return caught.value.code


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / "secret").write_bytes(SECRET)
    (tmp_path / "root").mkdir()
    return tmp_path / "root"


@pytest.fixture
def files(root: Path) -> Iterator[Files]:
    made = Files(root)
    yield made
    made.storage.__exit__()


def left(root: Path) -> list[str]:
    return [each.name for each in root.rglob(f"{TEMPORARY}*")]


def test_a_picture_goes_up_and_down_bit_exact(files: Files, root: Path) -> None:
    picture = bytes(range(256)) * 1000
    files.set("image.jpg", picture)
    assert files.get("image.jpg") == picture == (root / "image.jpg").read_bytes()
    assert files.get("image.jpg.meta.size") == "256000"
    assert hashlib.sha256(picture).hexdigest() in str(files.get("image.jpg.meta"))
    files.set("image.jpg", b"")
    assert files.get("image.jpg") == b""
    files.set("image.jpg?delete=1", b"")
    assert files.code("image.jpg") == "unknown"
    assert files.code("image.jpg?delete=1", b"") == "unknown"
    assert not left(root)


def test_directories_are_parts_of_names(files: Files, root: Path) -> None:
    files.set("my%20pictures?directory=1", b"")
    files.set("my%20pictures.a%20ball.jpg", b"ball")
    assert (root / "my pictures" / "a ball.jpg").read_bytes() == b"ball"
    files.set("my%20pictures.2026?directory=1", b"")
    files.set("my%20pictures.2026.ball.jpg", b"b")
    assert (root / "my pictures" / "2026" / "ball.jpg").read_bytes() == b"b"
    assert "my%20pictures" in str(files.get("properties"))
    assert files.get("my%20pictures") == '("2026" a%20ball)'
    assert files.code("my%20pictures", b"file") == "conflict"
    assert files.code("my%20pictures?delete=1", b"") == "conflict"
    files.set("empty?directory=1", b"")
    assert files.get("empty") == "()"
    assert files.code("empty?directory=1", b"") == "conflict"
    files.set("empty?delete=1", b"")
    assert not (root / "empty").exists()


def test_files_that_want_one_name_have_two(files: Files, root: Path) -> None:
    (root / "a").mkdir()
    (root / "a" / "b").write_bytes(b"deep")
    (root / "a.b").write_bytes(b"flat")
    (root / "notes.meta").write_bytes(b"notes")
    assert files.get("a.b") == b"deep"
    assert files.get("a%2Eb") == b"flat"
    assert files.get("notes%2Emeta") == b"notes"
    files.set("a%2Eb", b"new")
    assert (root / "a.b").read_bytes() == b"new"


def test_case_is_kept(files: Files, root: Path) -> None:
    files.set("Image.JPG", b"1")
    files.set("image.jpg", b"2")
    assert files.get("Image.JPG") == b"1"
    assert sorted(os.listdir(root)) == ["Image.JPG", "image.jpg"]


@pytest.mark.parametrize(
    "name",
    [
        "%2E%2E.secret", "%2E%2E%2Fsecret", "%2Fetc%2Fpasswd", "%2E%2E", "%2E", "a%00b", "a%5Cb",
        "C%3A", "%2Ehidden", "%0A", "%252E%252E%252Fsecret", "out.secret", "out", "file", "pipe",
        "socket", "null", "loop", "absolute", "x" * 250, "%2Ertkit-upload-0",
    ],
)  # fmt: skip
def test_nothing_leads_outside(files: Files, root: Path, name: str) -> None:
    (root / "out").symlink_to("..")
    (root / "file").symlink_to("../secret")
    (root / "absolute").symlink_to(root.parent / "secret")
    (root / "loop").symlink_to("loop")
    (root / ".hidden").write_bytes(b"h")
    os.mkfifo(root / "pipe")
    (root / "null").symlink_to("/dev/null")
    with socket.socket(socket.AF_UNIX) as end:
        os.chdir(root)
        end.bind("socket")
    before = sorted(os.listdir(root.parent))
    assert files.code(name) == "unknown"
    assert files.code(f"{name}?delete=1", b"") == "unknown"
    if name in ("out.secret", "%252E%252E%252Fsecret", "x" * 250):
        files.set(name, b"mine")  # a file of just that name, beside the link
        assert files.get(name) == b"mine"
    else:
        assert files.code(name, b"mine") in ("denied", "conflict")
    assert (root.parent / "secret").read_bytes() == SECRET
    assert sorted(os.listdir(root.parent)) == before
    assert SECRET.decode() not in str(files.get("properties?all=1&values=1"))
    assert int(str(files.get("left_out"))) == 7


def test_a_device_is_no_file(root: Path) -> None:
    files = Files(Path("/dev"))
    assert "null" not in str(files.get("properties"))
    assert files.code("null") == "unknown"
    assert files.code("zero", b"") in ("conflict", "denied")
    files.storage.__exit__()


def test_what_is_swapped_meanwhile_leads_nowhere(files: Files, root: Path) -> None:
    """A directory is exchanged for a link to outside as fast as it goes."""
    inside, outside = root / "d", root.parent / "outside"
    outside.mkdir()
    (outside / "f").write_bytes(SECRET)
    inside.mkdir()
    (inside / "f").write_bytes(b"inside")
    link = root / "link"
    link.symlink_to(outside)
    ended = threading.Event()

    def swap() -> None:
        while not ended.is_set():
            os.rename(inside, root / "kept")
            os.rename(link, inside)
            os.rename(inside, link)
            os.rename(root / "kept", inside)

    thread = threading.Thread(target=swap)
    thread.start()
    got, refused = 0, 0
    try:
        begin = time.monotonic()
        while (waited := time.monotonic() - begin) < 1.0 or (got <= 10 and waited < 20.0):
            for target, payload in (("d.f", None), ("d.g", b"mine"), ("d.g?delete=1", b"")):
                try:
                    found = files.get(target) if payload is None else files.set(target, payload)
                    assert SECRET not in bytes(found) if isinstance(found, bytes) else True
                    got += 1
                except PropertyError:
                    refused += 1
    finally:
        ended.set()
        thread.join()
    assert got > 10
    assert os.listdir(outside) == ["f"]
    assert (outside / "f").read_bytes() == SECRET


def test_a_large_file_goes_in_blocks(files: Files, root: Path) -> None:
    data = random.Random(1).randbytes(50 * MIB + 17)
    files.set("big.bin", b"old")
    for offset in range(0, len(data), BLOCK):
        assert files.get("big.bin") == b"old"
        files.set(f"big.bin?offset={offset}&size={len(data)}", data[offset : offset + BLOCK])
    assert files.code("big.bin") == "too-large"
    assert files.code(f"big.bin?length={2 * BLOCK}") == "too-large"
    size = int(str(files.get("big.bin.meta.size")))
    blocks = [files.get(f"big.bin?offset={at}&length={BLOCK}") for at in range(0, size, BLOCK)]
    assert b"".join(map(bytes, blocks)) == data  # type: ignore[arg-type]
    for far in (size, size + 1, 1 << 70):
        assert files.get(f"big.bin?offset={far}&length=5") == b""
    assert files.get(f"big.bin?offset={size - 3}&length={1 << 70}") == data[-3:]
    for wrong in ("offset=-1", "length=-2", "offset=x"):
        assert files.code(f"big.bin?{wrong}") == "bad-parameter"
    for wrong in ("offset=-2", "offset=0", "offset=0&size=-2", "offset=1e9", "size=-7", "size=2"):
        assert files.code(f"big.bin?{wrong}", b"x") == "bad-parameter"
    assert files.code(f"big.bin?offset=0&size={1 << 70}", b"x") == "too-large"
    assert hashlib.sha256(data).hexdigest() in str(files.get("big.bin.meta.sha256"))
    assert not left(root)


def test_an_upload_that_ends_half_way_leaves_the_file_as_it_was(files: Files, root: Path) -> None:
    files.set("f", b"old")
    files.set("f?offset=0&size=10", b"12345")
    assert len(left(root)) == 1
    assert files.get("f") == b"old"
    assert files.code("f?offset=7&size=10", b"89") == "conflict"
    assert files.code("f?offset=5&size=11", b"6") == "bad-parameter"
    assert files.code("f?offset=5&size=10", b"678901") == "bad-parameter"
    files.set("f?offset=5&size=10", b"67")
    files.set("f?offset=5&size=10", b"678")  # a block once more
    assert files.code(f"f?offset=8&sha256={'0' * 64}", b"90") == "bad-value"
    assert files.get("f") == b"old"
    assert not left(root)
    assert files.code("f?offset=8", b"90") == "conflict"
    files.set("f?offset=0&size=3", b"1")
    files.set("f", b"whole")
    files.set("f?offset=1&size=3", b"23")
    assert files.get("f") == b"123"
    files.set("f?offset=0&size=10&upload=mine", b"12345")
    files.set("f?offset=0&size=10&upload=yours", b"abcde")
    files.set("f?offset=5&upload=mine", b"67890")
    assert files.get("f") == b"1234567890"
    files.storage.__exit__()
    assert not left(root)
    assert (root / "f").read_bytes() == b"1234567890"


def test_what_a_killed_upload_has_left_is_removed(root: Path) -> None:
    (root / f"{TEMPORARY}0").write_bytes(b"half")
    os.utime(root / f"{TEMPORARY}0", (0, 0))
    files, other = Files(root), Files(root)
    assert not left(root)
    files.set("f?offset=0&size=10", b"12345")
    assert " f" not in str(other.get("properties"))
    assert len(left(root)) == 1
    for each in (files, other):
        each.storage.__exit__()


def test_limits(root: Path) -> None:
    files = Files(root, quota=100, largest=60, most=3)
    assert files.code("a", b"x" * 61) == "too-large"
    files.set("a", b"x" * 60)
    assert files.code("b", b"x" * 60) == "too-large"
    files.set("b?offset=0&size=40", b"x")
    assert files.code("c", b"x") == "too-large"  # what is to come counts
    files.set("b?offset=1", b"x" * 39)
    assert files.get("used") == "100"
    files.set("a?delete=1", b"")
    files.set("a", b"")
    files.set("c", b"")
    assert files.code("d", b"") == "too-large"
    files.set("a", b"y")
    files.storage.__exit__()


def test_a_file_is_replaced_where_there_is_no_room_for_two(root: Path) -> None:
    files = Files(root, quota=100)
    files.set("a", b"x" * 90)
    files.set("a", b"y" * 95)
    assert files.get("used") == "95"
    assert files.code("a", b"z" * 101) == "too-large"
    assert files.code("b", b"z" * 6) == "too-large"
    files.set("a?offset=0&size=20", b"z" * 10)
    assert files.code("b", b"z" * 81) == "too-large"  # what is to come counts
    assert files.code("b", b"z" * 6) == "too-large"  # until then the old one is there
    files.set("a?offset=10", b"z" * 10)
    files.set("b", b"z" * 80)
    assert files.get("used") == "100"
    files.set("a?offset=0&size=20", b"z" * 10)
    files.set("a?delete=1", b"")
    assert files.code("b", b"z" * 81) == "too-large"  # it no longer replaces one
    files.storage.__exit__()


def test_what_is_over_the_quota_may_shrink(root: Path) -> None:
    (root / "a").write_bytes(b"x" * 90)
    (root / "b").write_bytes(b"x" * 90)
    files = Files(root, quota=100)
    files.set("a", b"x" * 89)
    assert files.code("a", b"x" * 90) == "too-large"
    files.storage.__exit__()


def test_errors_of_the_system_tell_no_path(files: Files, root: Path) -> None:
    files.set("f", b"1")
    if os.getuid():
        (root / "f").chmod(0)
        assert files.code("f") == "denied"
    (root / "f").unlink()
    (root / "f").mkdir()
    assert files.code("f", b"x") == "conflict"
    assert files.code("g.h.i?delete=1", b"") == "unknown"
    gone = Files.__new__(Files)
    with pytest.raises(PropertyError) as caught:
        gone.__init__(root / "none")  # type: ignore[misc]
    assert str(root) not in str(caught.value)


def test_search(files: Files, root: Path) -> None:
    for name, text in (("a.txt", "red ball"), ("b.txt", "blue"), ("p.jpg", "red"), ("q.png", "")):
        files.set(name, text.encode())
    os.utime(root / "a.txt", (1000, 1000))
    assert files.get("search") == "(a.txt b.txt p.jpg q.png)"
    assert files.get("search?name=*.txt") == "(a.txt b.txt)"
    assert files.get("search?type=image") == "(p.jpg q.png)"
    assert files.get("search?type=image/png") == files.get("search?type=png") == "(q.png)"
    assert files.get("search?newer=2000&name=*.txt") == "(b.txt)"
    assert files.get("search?text=red") == "(a.txt p.jpg)"
    assert files.get("search?text=red&type=txt") == "(a.txt)"
    (root / "some balls").mkdir()
    (root / "some balls" / "ball 1.jpg").write_bytes(b"")
    assert files.get("search?name=*.jpg") == "(some%20balls.ball%201.jpg p.jpg)"
    assert files.get('search?name="ball *.jpg"') == "(some%20balls.ball%201.jpg)"
    assert files.get("search?name=some%2520balls.*") == "(some%20balls.ball%201.jpg)"
    assert files.code("search?wrong=1") == "bad-parameter"


@pytest.fixture
def many() -> Iterator[Files]:
    memory = "/dev/shm" if Path("/dev/shm").is_dir() else None
    with tempfile.TemporaryDirectory(dir=memory) as folder:
        for number in range(10_000):
            if number % 100 == 0:
                (Path(folder) / f"d{number // 100}").mkdir()
            (Path(folder) / f"d{number // 100}" / f"f{number % 100}.jpg").touch()
        yield Files(Path(folder))


def test_ten_thousand_files_are_listed_fast(many: Files) -> None:
    files = many
    begin = time.perf_counter()
    files.get("properties?depth=3")
    first_s = time.perf_counter() - begin
    time.sleep(0.05)
    files.get("properties")
    begin = time.perf_counter()
    for _ in range(10):
        files.get("properties")
    again_s = (time.perf_counter() - begin) / 10
    begin = time.perf_counter()
    for number in range(10):
        files.set(f"d7.new{number}", b"x")
    set_s = (time.perf_counter() - begin) / 10
    begin = time.perf_counter()
    assert len(str(files.get("search?name=d7.*.jpg")).split()) == 100
    search_s = time.perf_counter() - begin
    # Quiet: 0.25 s, 0.7 ms, 17 ms, 4 ms; a look at each file for each listing would be 100 ms.
    assert first_s < 10.0
    assert again_s < 0.05
    assert max(set_s, search_s) < 2.0


@pytest.mark.parametrize("wire", ["unix", "tcp", "http"])
def test_fifty_megabytes_over_a_wire(place: str, root: Path, wire: str) -> None:
    data = random.Random(2).randbytes(50 * MIB if wire == "unix" else 3 * MIB + 1)
    ends = {"unix": {}, "tcp": {"port": 0}, "http": {"http": 0}}[wire]
    with rtkit.serve(Storage(str(root)), "files", **ends) as served, rtkit.Client(20.0) as client:  # type: ignore[arg-type]
        where = {
            "unix": "files.",
            "tcp": f"tcp:localhost:{served.port}/files.",
            "http": f"http://localhost:{served.http}/ps/files/",
        }[wire]
        target = f"{where}my%20video.mp4"
        client.set_bytes(target, data)
        assert client.get_bytes(target) == data
        assert client.get(f"{target}.meta.sha256") == hashlib.sha256(data).hexdigest()
        for small in (b"\x00{5}\n=", b"12", b"", b"{3}", b"a\r\n", b" (1 2 "):
            client.set_bytes(f"{where}small", small)
            assert client.get_bytes(f"{where}small") == small
            assert client.get_bytes(f"{where}small", offset=1, length=1) == small[1:2]
    assert not left(root)


@pytest.mark.parametrize("has_watch", [True, False], ids=["watchfiles", "without"])
def test_changes_from_outside_are_told(
    place: str, root: Path, monkeypatch: pytest.MonkeyPatch, has_watch: bool
) -> None:
    if not has_watch:
        monkeypatch.setitem(sys.modules, "watchfiles", None)
    (root / "a.txt").write_text("old")
    names: SimpleQueue[object] = SimpleQueue()
    texts: SimpleQueue[object] = SimpleQueue()
    storage = Storage(str(root))
    with rtkit.serve(storage, "files"), rtkit.Client(20.0) as client:
        client.listen("files.properties", lambda each: names.put(each.value), mode="diff", queue=9)
        client.listen("files.a.txt", lambda each: texts.put((each.value, each.code)))
        names.get(timeout=20)
        assert texts.get(timeout=20) == ("old", "")
        (root / "b.txt").write_text("b")
        assert names.get(timeout=20) == (("added", "b.txt"), ("removed",))
        (root / "sub").mkdir()
        assert names.get(timeout=20) == (("added", "sub"), ("removed",))
        (root / "sub" / "c").write_text("c")
        assert names.get(timeout=20) == (("added", "sub.c"), ("removed",))
        until = time.monotonic() + 20
        while storage.has_changed() == has_watch:
            assert time.monotonic() < until
            time.sleep(0.05)
        (root / "a.txt").write_text("newer")
        changed = texts.get(timeout=20)
        while changed == ("", ""):  # between its end and its new content
            changed = texts.get(timeout=20)
        assert changed == ("newer", "")
        os.rename(root / "b.txt", root / "d.txt")
        assert names.get(timeout=20) == (("added", "d.txt"), ("removed", "b.txt"))
        (root / "a.txt").unlink()
        assert names.get(timeout=20) == (("added",), ("removed", "a.txt"))
        assert texts.get(timeout=20)[1] == "unknown"  # type: ignore[index]


def test_who_listens_to_a_file_that_is_not_there_hears_so(place: str, root: Path) -> None:
    with rtkit.serve(Storage(str(root)), "files"), rtkit.Client(20.0) as client:
        with pytest.raises(PropertyError, match=r"no such property: b\.txt") as caught:
            client.listen("files.b.txt", print)
        assert caught.value.code == "unknown"


_KILLED = """
import rtkit, sys
from rtkit.services.storage import Storage
with rtkit.serve(Storage(sys.argv[1]), "files"):
    with rtkit.Client() as client:
        client.set("files.f", b"old")
        client.set("files.f", b"x" * 1000, offset=0, size=2000)
    print("half", flush=True)
    sys.stdin.read()
"""


def test_a_storage_that_is_killed_in_an_upload_leaves_nothing_half(place: str, root: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", _KILLED, str(root)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as owner:
        assert owner.stdout is not None
        assert owner.stdout.readline() == "half\n"
        assert len(left(root)) == 1
        owner.kill()
    for each in left(root):
        os.utime(root / each, (0, 0))
    with rtkit.serve(Storage(str(root)), "files"), rtkit.Client(20.0) as client:
        assert client.get_bytes("files.f") == b"old"
        assert not left(root)


def test_whoever_reads_gets_one_file_or_the_other(place: str, root: Path) -> None:
    contents = [bytes([n]) * 300_000 for n in range(4)]
    with rtkit.serve(Storage(str(root), synced=False), "files"), rtkit.Client(20.0) as client:
        client.set_bytes("files.f", contents[0])
        ended = threading.Event()

        def write(own: bytes) -> None:
            with rtkit.Client(20.0) as writer:
                while not ended.is_set():
                    writer.set_bytes("files.f", own)
                    half = {"offset": 0, "size": len(own) + 1, "upload": str(own[0])}
                    writer.set("files.f", own, **half)  # and never goes on

        threads = [threading.Thread(target=write, args=(each,)) for each in contents[1:]]
        for thread in threads:
            thread.start()
        try:
            seen = {client.get_bytes("files.f") for _ in range(50)}
            until = time.monotonic() + 20
            while len(seen) < 2 and time.monotonic() < until:
                seen.add(client.get_bytes("files.f"))
            sums = {hashlib.sha256(each).hexdigest() for each in contents}
            assert client.get("files.f.meta.sha256") in sums
        finally:
            ended.set()
            for thread in threads:
                thread.join()
    assert seen <= set(contents)
    assert len(seen) > 1
    assert not left(root)


def test_it_stands_beside_other_services_at_one_endpoint(place: str, root: Path) -> None:
    served = {"files": Storage(str(root)), "more": Storage(str(root), largest=2)}
    with rtkit.serve(served, "home"), rtkit.Client(20.0) as client:
        client.set_bytes("home.files.a.txt", b"hello")
        assert client.get_bytes("home.more.a.txt") == b"hello"
        with pytest.raises(PropertyError) as caught:
            client.set_bytes("home.more.b.txt", b"hello")
        assert caught.value.code == "too-large"


def test_a_root_that_is_not_there_is_named_to_who_starts_it_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    storage = Storage("notes")
    with pytest.raises(PropertyError, match=f"^its root {tmp_path}/notes cannot be opened: "):
        storage.__enter__()
    assert storage.status == "failed: its root cannot be opened: there is no such file"
