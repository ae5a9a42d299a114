"""Keeps documents that are not saved in the state folder, and offers those of servers that ended.

Each server has a folder of its own below ``web-drafts``, whose file ``alive`` it locks as long as
it lives: the kernel gives the lock up however the server ends.
"""

from __future__ import annotations

import fcntl
import json
import os
import secrets
from collections.abc import Iterator, Sequence
from contextlib import suppress
from datetime import datetime
from hashlib import sha256
from typing import NamedTuple

from rtkit.api.live_records import Record
from rtkit.errors import NotFound, RtkitError
from rtkit.link.atomic import write_output
from rtkit.link.places import make_private, state_dir
from rtkit.profile.examine import examine
from rtkit.profile.forms import XML
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.write import write_profile
from rtkit.profile_tools.system_edits import identity
from rtkit.web.documents.document import Document

_FOLDER = "web-drafts"
_ALIVE = "alive"
_ENDING = ".json"
_MOST_OFFERED = 32


class DocumentDraft(NamedTuple):
    """A document that was not saved when its server ended.

    Attributes:
        id: Its folder and number.
        file: That of the document; empty for one that had none.
        base: Digest of what the file held.
        profile: The document as it was.
    """

    id: str
    file: str
    base: str
    time: str
    profile: RtsProfile

    def record(self) -> Record:
        """Return what a list of drafts tells of it."""
        name = identity(self.profile)[1]
        return {"id": self.id, "file": self.file, "name": name, "time": self.time}


class DocumentDrafts:
    """The drafts of one server, and those that others have left."""

    def __init__(self) -> None:
        """Have none; the folder is made with the first one."""
        self._name = f"{os.getpid()}-{secrets.token_hex(4)}"
        self._lock: int | None = None

    def keep(self, document: Document) -> None:
        """Write a document down as it is now; one that is as its file is has no draft.

        What hinders that is a finding of the document.
        """
        document.draft_trouble = ""
        try:
            if not document.is_changed:
                self.drop_own(document)
                return
            self._begin()
            record = {
                "file": document.file,
                "base": digest(document.data),
                "time": datetime.now().astimezone().replace(microsecond=0).isoformat(),
                "text": write_profile(document.profile, XML).decode(),
            }
            path = self._path(f"{self._name}/{document.id}")
            write_output(json.dumps(record).encode(), path, mode=0o600)
        except RtkitError as error:
            document.draft_trouble = str(error)

    def drop_own(self, document: Document) -> None:
        """Forget the draft of a document that is closed."""
        self.drop(f"{self._name}/{document.id}")

    def drop(self, id: str) -> None:
        """Forget a draft; one that is gone already is none."""
        with suppress(FileNotFoundError):
            os.remove(self._path(id))

    def found(self, folders: Sequence[str]) -> list[DocumentDraft]:
        """Return the drafts of servers that ended, latest first: those of granted folders."""
        granted = tuple(os.path.join(each, "") for each in folders)
        drafts = [each for each in self._left() if not each.file or each.file.startswith(granted)]
        return sorted(drafts, key=lambda each: each.time, reverse=True)[:_MOST_OFFERED]

    def one(self, id: str, folders: Sequence[str]) -> DocumentDraft:
        """Return a draft.

        Raises:
            NotFound: There is none.
        """
        draft = next((each for each in self.found(folders) if each.id == id), None)
        if draft is None:
            raise NotFound(f"No such draft: {id}")
        return draft

    def close(self) -> None:
        """Give the lock up: what is left is offered by the next server."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None
            with suppress(OSError):  # there are drafts in it
                os.remove(os.path.join(_folder(), self._name, _ALIVE))
                os.rmdir(os.path.join(_folder(), self._name))

    def _begin(self) -> None:
        if self._lock is None:
            make_private(state_dir())
            make_private(_folder())
            folder = make_private(os.path.join(_folder(), self._name))
            lock = os.open(os.path.join(folder, _ALIVE), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC)
            fcntl.lockf(lock, fcntl.LOCK_EX)
            self._lock = lock

    def _left(self) -> Iterator[DocumentDraft]:
        names = os.listdir(_folder()) if os.path.isdir(_folder()) else []
        for name in names:
            if name == self._name or _is_alive(os.path.join(_folder(), name)):
                continue
            for file in os.listdir(os.path.join(_folder(), name)):
                if file.endswith(_ENDING):
                    id = f"{name}/{file.removesuffix(_ENDING)}"
                    draft = _read(id, self._path(id))
                    if draft is not None:
                        yield draft

    def _path(self, id: str) -> str:
        return os.path.join(_folder(), f"{id}{_ENDING}")


def digest(data: bytes) -> str:
    """Return what tells whether a file holds the same as before."""
    return sha256(data).hexdigest()


def _folder() -> str:
    return os.path.join(state_dir(), _FOLDER)


def _is_alive(folder: str) -> bool:
    """Return whether the server of a folder lives: it holds the lock."""
    try:
        descriptor = os.open(os.path.join(folder, _ALIVE), os.O_RDWR | os.O_CLOEXEC)
    except FileNotFoundError:
        return False
    try:
        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return True
    finally:
        os.close(descriptor)
    return False


def _read(id: str, path: str) -> DocumentDraft | None:
    """Return a draft; None for a file that is none, as after a fault of the disk."""
    try:
        with open(path, "rb") as stream:
            record = json.load(stream)
        profile = examine(record["text"].encode(), path, kind="rts").profile
        file, base, time = (str(record[key]) for key in ("file", "base", "time"))
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RtkitError):
        return None
    return DocumentDraft(id, file, base, time, profile) if isinstance(profile, RtsProfile) else None
