"""Storage: the files of a directory as properties, with sub-directories as parts of names.

``GET image.jpg``, ``SET image.jpg``, ``SET image.jpg?delete=1``. A file is replaced at once, or not
at all. Large ones go in blocks: ``GET f?offset=&length=``, ``SET f?offset=&size=``; the block with
which the upload has its size makes it the file. `paths` has the rules of names, `directory` keeps
within the root. Names are looked at again when a directory has changed, which `watchfiles` tells,
else a look at each of them.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from fnmatch import fnmatchcase
from math import inf
from mimetypes import guess_type
from time import monotonic, time
from typing import Any, Final, NamedTuple, Self

from rtkit import Names, PropertyError, Word, init_of
from rtkit.services.directory import Directory, Folder, Upload
from rtkit.services.paths import Path, names_of, path_of

BLOCK = 1 << 20
"""The most that one request carries [bytes]."""
MOST_UPLOADS = 16
_MOST_SUMS = 1000
_WHOLE = "/"
"""The upload of a file that comes in one piece, beside which another one may go on."""
UPLOAD_IDLE_S = 60.0
_STEP_MS, _DEBOUNCE_MS = 20, 50
_SURE_S = 2.0
"""How long it may take until all directories are watched [s]."""
_OWN = {"name", "type", "status", "version", "search", "used", "quota", "largest", "left_out"}


class _Listed(NamedTuple):
    """Names that there are, with the paths that they stand for.

    Attributes:
        left_out: How many files and links are there that are none.
    """

    files: Mapping[str, Path]
    folders: Mapping[str, Path]
    left_out: int


class Storage(Names):
    """Stores files below a directory.

    Args:
        root: The directory; a relative one from where the process was started.
        quota: How much all files together may hold [bytes]; 0 for any.
        largest: How much one may hold [bytes].
        most: How many files and directories have names.
        hidden: Files whose names begin with a dot are among them.
        synced: A file is on the disk before its SET is answered.

    Attributes:
        quota: How much all files together may hold [bytes]; 0 for any.
        largest: How much one may hold [bytes].
    """

    type: Final = ("storage",)
    version: Final = "1.0"
    quota: Final[int]
    largest: Final[int]

    def __init__(
        self,
        root: str,
        *,
        quota: int = 1 << 30,
        largest: int = 1 << 28,
        most: int = 20_000,
        hidden: bool = False,
        synced: bool = True,
    ) -> None:
        self.quota = quota
        self.largest = largest
        self._where, self._most, self._hidden, self._synced = root, most, hidden, synced
        self._lock = threading.RLock()
        self._directory: Directory | None = None
        self._folders: dict[Path, Folder] = {}
        self._listed = _Listed({}, {}, 0)
        self._names: tuple[str, ...] = ()
        self._uploads: dict[tuple[str, str], Upload] = {}
        self._sums: dict[Path, tuple[object, str]] = {}
        self._used: tuple[float, int] = (-inf, 0)
        self._stop = threading.Event()
        self._is_changed: threading.Event | None = None
        self._sure_at = 0.0

    # Begin and end

    def __enter__(self) -> Self:
        self._stop.clear()
        self._files(f" {os.path.abspath(self._where)}")
        try:
            from watchfiles import watch
        except ImportError:
            return self  # directories are looked at as often as somebody listens
        changes = watch(
            self._where,
            watch_filter=None,
            debounce=_DEBOUNCE_MS,
            step=_STEP_MS,
            rust_timeout=500,
            stop_event=self._stop,
            raise_interrupt=False,
            ignore_permission_denied=True,
        )
        changed = self._is_changed = threading.Event()
        self._sure_at = monotonic() + _SURE_S
        threading.Thread(target=self._watch, args=(changes, changed), daemon=True).start()
        return self

    def _watch(self, changes: Iterator[object], changed: threading.Event) -> None:
        with suppress(OSError, RuntimeError):  # more than the system watches: each is looked at
            for _ in changes:
                changed.set()
        if self._is_changed is changed:
            self._is_changed = None

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        with self._lock:
            self._is_changed = None
            for key in list(self._uploads):
                self._uploads.pop(key).close()
            if self._directory is not None:
                self._directory.close()
            self._directory = None

    @property
    def status(self) -> str:
        """``ready``, or ``failed`` with the reason."""
        try:
            self._files()
        except PropertyError as error:
            return f"failed: {error}"
        return "ready"

    def _files(self, root: str = "") -> Directory:
        """Return the directory; where it is, `root`, is told to who starts the service only."""
        with self._lock:
            if self._directory is None:
                try:
                    self._directory = Directory(
                        self._where, hidden=self._hidden, is_synced=self._synced
                    )
                except PropertyError as error:
                    raise PropertyError(
                        error.code, f"its root{root} cannot be opened: {error}"
                    ) from None
            return self._directory

    # Names

    def names(self) -> Collection[str]:
        """See `rtkit.Names.names`."""
        with self._lock:
            self._look()
            return self._names

    def has_changed(self) -> bool:
        """See `rtkit.Names.has_changed`."""
        changed = self._is_changed
        return changed is None or changed.is_set() or monotonic() < self._sure_at

    def _look(self) -> _Listed:
        """Look again at directories that have changed."""
        directory = self._files()
        if self._is_changed is not None:
            self._is_changed.clear()
        found: dict[Path, Folder] = {}
        waiting: list[Path] = [()]
        while waiting:
            path = waiting.pop()
            folder = self._folders.get(path)
            if folder is None or folder.mark != directory.mark(path):
                try:
                    folder = directory.look(path)
                except PropertyError as error:
                    if error.code == "internal" or not path:
                        raise
                    continue  # it has gone meanwhile, or may not be read
            found[path] = folder
            waiting += [(*path, each) for each in folder.folders]
        before, self._folders = self._folders, found
        if before.keys() != found.keys() or any(
            before[path].held != folder.held for path, folder in found.items()
        ):
            self._listed = self._named(found)
            self._names = (*self._listed.folders, *self._listed.files)
        return self._listed

    def _named(self, found: dict[Path, Folder]) -> _Listed:
        """Give each file its name: where two want the same one, the deeper has it."""
        files: dict[str, Path] = {}
        folders: dict[str, Path] = {}
        left_out = 0
        for path in sorted(found, key=len, reverse=True):
            folder = found[path]
            left_out += folder.left_out
            for kind, names in ((files, folder.files), (folders, folder.folders)):
                for each in names:
                    whole = (*path, each)
                    for name in names_of(whole) if len(files) + len(folders) < self._most else ():
                        if name not in files and name not in folders and name not in _OWN:
                            kind[name] = whole
                            break
                    else:
                        left_out += 1
        return _Listed(files, folders, left_out)

    def hint(self, name: str) -> Any:
        """See `rtkit.Names.hint`: directories are lists of names."""
        return object if name in self._listed.folders else None

    def stamp(self, name: str) -> object:
        """See `rtkit.Names.stamp`."""
        if name in self._listed.folders:
            return self._files().mark(self._listed.folders[name])
        found = self._files().status(self._path(name))
        return found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns

    def about(self, name: str) -> Mapping[str, Any]:
        """See `rtkit.Names.about`: size, time, SHA-256 of a file."""
        if name in self._listed.folders:
            return {}
        path, stamp = self._path(name), self.stamp(name)
        known = self._sums.get(path)
        found = self._files().status(path)
        if known is None or known[0] != stamp or time() - found.st_mtime < 1.0:
            known = (stamp, self._files().digest(path))
            self._sums = {path: known} | dict(list(self._sums.items())[:_MOST_SUMS])
        return {"size": found.st_size, "time": found.st_mtime, "sha256": known[1]}

    def _path(self, name: str) -> Path:
        path = self._listed.files.get(name)
        if path is None:
            raise PropertyError("unknown", f"no such property: {name}")
        return path

    # Values

    def get(self, name: str, offset: int = 0, length: int = -1) -> bytes:
        """See `rtkit.Names.get`: a file or a block of it; of a directory the names below.

        Raises:
            PropertyError: ``too-large``: it is to be got in blocks.
        """
        if name in self._listed.folders:
            self.names()
            return self._below(name)  # type: ignore[return-value]
        if offset < 0 or length < -1:
            raise PropertyError("bad-parameter", "offset and length are not negative")
        path = self._path(name)
        size = self._files().status(path).st_size
        offset = min(offset, size)
        wanted = min(length, size - offset) if length >= 0 else size - offset
        if wanted > BLOCK:
            text = f"{wanted} bytes: get blocks of at most {BLOCK}, ?offset=&length="
            raise PropertyError("too-large", text)
        return self._files().read(path, offset, wanted)

    def _below(self, name: str) -> list[Word]:
        prefix = f"{name}."
        below = {each.removeprefix(prefix).partition(".")[0] for each in self._names
                 if each.startswith(prefix)}  # fmt: skip
        return [Word(each) for each in sorted(below)]

    def set(
        self,
        name: str,
        value: bytes,
        offset: int = -1,
        size: int = -1,
        upload: str = "",
        sha256: str = "",
        delete: bool = False,
        directory: bool = False,
    ) -> None:
        """See `rtkit.Names.set`: a whole file, a block of one, none any more, or a directory.

        Raises:
            PropertyError: ``denied``: no file may be called so; ``too-large``; ``conflict``: it is
                not the next block; ``bad-value``: the SHA-256 is another one.
        """
        with self._lock:
            if delete:
                files = self._listed.files | self._listed.folders  # type: ignore[operator]
                self._files().remove(files[name] if name in files else self._path(name))
                self._used = (-inf, 0)
                return
            if name in self._listed.folders:
                raise PropertyError("conflict", f"a directory: {name}")
            path = self._listed.files.get(name)
            if path is None:
                folders = set(self._listed.folders.values())
                path = path_of(name, folders, hidden=self._hidden)
                if len(self._names) >= self._most:
                    raise PropertyError("too-large", f"there are {self._most} files")
            if directory:
                self._files().make(path)
                return
            if offset < -1 or size < -1:
                raise PropertyError("bad-parameter", "offset and size are not negative")
            if offset < 0:
                if size not in (-1, len(value)):
                    raise PropertyError("bad-parameter", f"{len(value)} bytes came, not {size}")
                offset, size, upload = 0, len(value), _WHOLE
            self._put((name, upload), path, value, (offset, size), sha256)

    def _put(
        self,
        key: tuple[str, str],
        path: Path,
        value: bytes,
        place: tuple[int, int],
        digest: str,
    ) -> None:
        """Write a block of a file, the last of which makes it one."""
        offset, size = place
        self._end_idle()
        if offset == 0:
            self._begin(key, path, size)
        upload = self._uploads.get(key)
        if upload is None or not offset <= upload.size:
            at = 0 if upload is None else upload.size
            raise PropertyError("conflict", f"the block at {at} is to come next")
        if size not in (-1, upload.whole) or offset + len(value) > upload.whole:
            raise PropertyError("bad-parameter", f"the upload has a size of {upload.whole} bytes")
        try:
            upload.write(value, offset)
            if upload.size < upload.whole:
                return
            if digest and digest.lower() != upload.digest():
                raise PropertyError("bad-value", "the SHA-256 is another one")
            growth = self._growth(path, upload.whole)
            upload.commit(path[-1])
        except PropertyError:
            self._uploads.pop(key).close()
            raise
        self._uploads.pop(key).close()
        self._used = (self._used[0], self._used[1] + growth)

    def _begin(self, key: tuple[str, str], path: Path, size: int) -> None:
        if size < 0:
            raise PropertyError("bad-parameter", "the size of the whole file is needed: ?size=")
        if size > self.largest:
            raise PropertyError("too-large", f"{size} bytes, and {self.largest} are allowed")
        before = self._uploads.pop(key, None)
        if before is not None:
            before.close()
        if len(self._uploads) >= MOST_UPLOADS:
            raise PropertyError("busy", f"there are {MOST_UPLOADS} uploads")
        uploads = self._uploads.values()
        coming = sum(max(0, self._growth(each.path, each.whole)) for each in uploads)
        growth = self._growth(path, size)
        if self.quota and growth > 0 and self._now_used() + coming + growth > self.quota:
            raise PropertyError("too-large", f"{size} bytes more than fit in {self.quota}")
        self._uploads[key] = self._files().upload(path, size)

    def _growth(self, path: Path, size: int) -> int:
        """Return how much more is used when a file has a size [bytes]; it may replace one."""
        try:
            return size - self._files().status(path).st_size
        except PropertyError:
            return size  # there is none

    def _end_idle(self) -> None:
        for key, each in list(self._uploads.items()):
            if monotonic() - each.touched > UPLOAD_IDLE_S:
                self._uploads.pop(key).close()

    # Properties of all of them

    def _now_used(self) -> int:
        """Return what all files hold, as it was a second ago at most but for what was set here."""
        if monotonic() - self._used[0] > 1.0:
            used = 0
            for path in self._look().files.values():
                try:
                    used += self._files().status(path).st_size
                except PropertyError:
                    continue  # it has gone meanwhile
            self._used = (monotonic(), used)
        return self._used[1]

    def get_used(self) -> int:
        """Size of all files together [bytes]."""
        with self._lock:
            return self._now_used()

    def get_left_out(self) -> int:
        """Number of files, links and others that have no name here."""
        with self._lock:
            return self._look().left_out

    def get_search(
        self, name: str = "*", type: str = "", newer: float = 0.0, text: str = ""
    ) -> list[Word]:
        """Names of files: of a pattern, a kind (jpg, image, image/jpeg), newer, with a text."""
        with self._lock:
            listed = self._look()
        found = []
        for each, path in listed.files.items():
            is_named = fnmatchcase(each, name) or fnmatchcase(path[-1], name)
            if not (is_named and _is_kind(path[-1], type)):
                continue
            try:
                if newer and self._files().status(path).st_mtime <= newer:
                    continue
                if text and not self._files().contains(path, text.encode()):
                    continue
            except PropertyError:
                continue  # it has gone meanwhile, or may not be read
            found.append(Word(each))
        return found


def _is_kind(file: str, kind: str) -> bool:
    if not kind or file.lower().endswith(f".{kind.lower()}"):
        return True
    media = guess_type(file)[0] or ""
    return media == kind or media.startswith(f"{kind}/")


StorageInit = init_of(Storage)
