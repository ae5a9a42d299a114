"""Repositories of packages: folders of wheels, HTTP simple indexes, folders in git, bundles.

A git repository is ``git+URL[@REVISION][#subdirectory=FOLDER]``, as pip writes it.
"""

from __future__ import annotations

import html
import http.client
import json
import os
import re
import shutil
import tempfile
import time
import urllib.request
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import NamedTuple
from urllib.parse import parse_qs, unquote, urldefrag, urljoin, urlsplit

from packaging.utils import canonicalize_name
from packaging.version import Version

from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable
from rtkit.packages.bundle import is_bundle, unpacked
from rtkit.packages.precheck import known_repositories
from rtkit.packages.tools import git, git_head, is_git_empty
from rtkit.packages.wheel import Wheel, named, read_wheel

_LARGEST_PAGE = 1 << 26
_MOST_WHEELS = 20_000
_ANSWER_S = 30.0
_SEARCH_S = 60.0
"""How long the pages of an index are read [s]."""
_LINK = re.compile(r"""<a\s(?:[^<>]*\s)?href\s*=\s*["']?([^"'\s<>]+)""", re.IGNORECASE)
_WANTED = "application/vnd.pypi.simple.v1+json, text/html;q=0.5"


class Offer(NamedTuple):
    """A wheel that a repository has; of an HTTP index nothing more is known than its name."""

    name: str
    version: str
    file: str
    repository: str
    wheel: Wheel | None = None


class Repositories(NamedTuple):
    """Repositories that can be read now: git ones have been cloned.

    Attributes:
        folders: Folder of wheels by the repository as it was named.
        indexes: HTTP simple indexes.
    """

    folders: dict[str, str]
    indexes: list[str]

    def are_bundles(self) -> bool:
        """Return whether all that they have is in bundles, which are checked as a whole."""
        return not self.indexes and all(map(is_bundle, self.folders))

    def pip_options(self) -> list[str]:
        """Return where pip is to look, and nowhere else."""
        words = [] if self.indexes else ["--no-index"]
        for number, each in enumerate(self.indexes):
            words += ["--extra-index-url" if number else "--index-url", each]
        for folder in self.folders.values():
            words += ["--find-links", folder]
        return words


def named_repositories(given: Sequence[str]) -> list[str]:
    """Return those that were given, else those of the settings.

    Raises:
        NotFound: There is none.
    """
    found = known_repositories(given)
    if not found:
        raise NotFound(
            "no repository: name one by --repository, or in rtkit.toml, repositories = [...]"
        )
    return found


@contextmanager
def opened(names: Sequence[str]) -> Iterator[Repositories]:
    """Make repositories readable; clones are there until the end.

    Raises:
        NotFound: A folder is not there.
        Refused: A git repository cannot be cloned; an address has a secret in it.
    """
    found = Repositories({}, [])
    with ExitStack() as stack:
        for each in names:
            _check_no_secret(each)
            if each.startswith("git+"):
                found.folders[each] = stack.enter_context(_cloned(each))
            elif each.startswith(("http://", "https://")):
                found.indexes.append(each.rstrip("/") + "/")
            elif is_bundle(each):
                found.folders[each] = stack.enter_context(unpacked(each)).wheels
            else:
                folder = os.path.expanduser(each.removeprefix("file://"))
                if not os.path.isdir(folder):
                    raise NotFound(f"no such repository: {each} (a folder, URL or git+URL)")
                found.folders[each] = os.path.abspath(folder)
        yield found


def _check_no_secret(name: str) -> None:
    """Refuse an address that names who asks: pip and git are given it where others see it (ps)."""
    parts = urlsplit(name.removeprefix("git+"))
    if parts.password is not None or (parts.username and parts.scheme in ("http", "https")):
        plain = f"{parts.scheme}://{parts.netloc.rpartition('@')[2]}{parts.path}"
        hint = "write user and password into ~/.netrc, which pip and git read"
        raise Refused(f"a secret in the address of a repository: {plain} ({hint})")


@contextmanager
def _cloned(name: str, *, is_begun: bool = False) -> Iterator[str]:
    """Check a git repository out; one that `is_begun` here may be empty, or lack the folder."""
    url, revision, below = _git_place(name)
    with tempfile.TemporaryDirectory(prefix="rtpkg-") as folder:
        git("init", "-q", folder=folder)
        if is_git_empty(url):
            if not is_begun:
                raise NotFound(f"nothing is in the git repository yet: {name}")
        else:
            git("fetch", "-q", "--depth", "1", "--", url, revision or "HEAD", folder=folder)
            git("checkout", "-q", "FETCH_HEAD", folder=folder)
        inside = os.path.realpath(os.path.join(folder, below))
        if not f"{inside}/".startswith(f"{os.path.realpath(folder)}/"):
            raise Refused(f"folder leaves the git repository: {below}")
        if is_begun:
            os.makedirs(inside, exist_ok=True)
        if not os.path.isdir(inside):
            raise NotFound(f"no folder {below} in {name}")
        yield inside


def _git_place(name: str) -> tuple[str, str, str]:
    """Return URL, revision and folder of ``git+URL[@REVISION][#subdirectory=FOLDER]``."""
    plain, fragment = urldefrag(name.removeprefix("git+"))
    if urlsplit(plain).scheme not in ("file", "https", "http", "ssh"):
        raise Malformed(f"not a git repository by file, https or ssh: {name}")
    head, at, revision = plain.rpartition("@")
    if not at or "/" not in head.partition("://")[2]:  # it is the user of ssh://git@host
        head, revision = plain, ""
    return head, revision, parse_qs(fragment).get("subdirectory", [""])[0]


def offers(found: Repositories) -> Iterator[Offer | RtkitError]:
    """Yield all wheels of repositories, and what is wrong with some."""
    for name, folder in found.folders.items():
        for file in sorted(os.listdir(folder)):
            if file.endswith(".whl"):
                try:
                    wheel = read_wheel(os.path.join(folder, file))
                    yield Offer(wheel.name, wheel.version, file, name, wheel)
                except RtkitError as error:
                    yield error
    for index in found.indexes:
        try:
            yield from _of_index(index)
        except RtkitError as error:
            yield error


def _of_index(index: str) -> Iterator[Offer | RtkitError]:
    names = dict.fromkeys(map(canonicalize_name, _links(index, "projects", "name")))
    until = time.monotonic() + _SEARCH_S
    for number, name in enumerate(names):
        if time.monotonic() > until:
            raise Unreachable(f"{index} is too slow: {number} of {len(names)} packages were read")
        files = _links(urljoin(index, f"{name}/"), "files", "filename")
        wheels = [each for each in dict.fromkeys(files) if each.endswith(".whl")]
        if len(wheels) > _MOST_WHEELS:
            raise Malformed(f"{index}{name}/ lists more than {_MOST_WHEELS} wheels")
        for file in wheels:
            try:
                yield Offer(*named(file), file, index)
            except Malformed as error:
                yield Malformed(f"{index}{name}/: {error}")


def _links(url: str, key: str, name: str) -> list[str]:
    """Return the names on a page of a simple index, PEP 691 or 503."""
    request = urllib.request.Request(url, headers={"Accept": _WANTED})
    try:
        with urllib.request.urlopen(request, timeout=_ANSWER_S) as answer:
            data = _read_in_time(answer)
            is_json = "json" in (answer.headers.get("Content-Type") or "")
        if is_json:
            return [str(each[name]) for each in json.loads(data)[key]]
    except OSError as error:
        raise Unreachable(f"no answer of {url}: {error}") from None
    except (ValueError, KeyError, TypeError) as error:
        raise Malformed(f"{url} is no simple index: {error}") from None
    links = (html.unescape(each[1]) for each in _LINK.finditer(data.decode("utf-8", "replace")))
    paths = (each.partition("#")[0].partition("?")[0] for each in links)
    names = (unquote(path.rstrip("/").rpartition("/")[2]) for path in paths)
    return [name for name in names if name not in ("", ".", "..")]


def _read_in_time(answer: http.client.HTTPResponse) -> bytes:
    """Return a page; whoever sends it byte by byte has not more time than others.

    Raises:
        TimeoutError: It does not end in time, or is too large.
    """
    deadline, parts, size = time.monotonic() + _ANSWER_S, [b""], 0
    while part := answer.read1(1 << 16):
        size += len(part)
        if time.monotonic() > deadline or size > _LARGEST_PAGE:
            raise TimeoutError("the page does not end")
        parts.append(part)
    return b"".join(parts)


def newest_first(found: list[Offer]) -> list[Offer]:
    """Return offers sorted by name, the newest version of each first."""
    newest = sorted(found, key=lambda each: Version(each.version), reverse=True)
    return sorted(newest, key=lambda each: each.name)


def publish(path: str, repository: str) -> None:
    """Put a wheel into a repository: a folder, or a git repository, to which it is pushed.

    Raises:
        Refused: Another wheel of that name is there, or the repository takes none.
    """
    if repository.startswith(("http://", "https://")):
        raise Refused(
            f"a simple index takes no wheels: {repository}"
            " (publish to the folder that it serves, or upload by twine)"
        )
    if is_bundle(repository):
        raise Refused(f"a bundle takes no wheels: {repository} (rtpkg bundle makes another)")
    if not repository.startswith("git+"):
        with opened([repository]) as found:
            (folder,) = found.folders.values()
            _put(path, folder)
        return
    with _cloned(repository, is_begun=True) as folder:
        if _put(path, folder):
            url, revision, _ = _git_place(repository)
            file = os.path.basename(path)
            git("add", "-f", "--", file, folder=folder)
            git("commit", "-q", "-m", f"Publish {file}", folder=folder)
            if revision and is_git_empty(url):
                revision = f"refs/heads/{revision}"
            git("push", "-q", "--", url, f"HEAD:{revision or git_head(url)}", folder=folder)


def _put(path: str, folder: str) -> bool:
    """Copy a wheel into a folder, where it is whole or not at all; return whether it is new."""
    wheel = read_wheel(path)
    target = os.path.join(folder, wheel.file)
    with tempfile.NamedTemporaryFile(dir=folder, prefix=".", delete=False) as draft:
        try:
            with open(path, "rb") as source:
                shutil.copyfileobj(source, draft)
            draft.flush()
            os.fchmod(draft.fileno(), 0o644)
            os.fsync(draft.fileno())
            os.link(draft.name, target)  # which replaces nothing
        except FileExistsError:
            if read_wheel(target).sha256 != wheel.sha256:
                raise Refused(
                    f"another {wheel.file} is in {folder}: a changed package needs a new version"
                ) from None
            return False
        finally:
            os.unlink(draft.name)
    return True
