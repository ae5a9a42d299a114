"""Path rules: which names stand for which files, and which for none."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as some

from rtkit import PropertyError
from rtkit.services.paths import is_allowed, names_of, path_of

PARTS = some.text(min_size=1, max_size=12).filter(is_allowed)
PATHS = some.lists(PARTS, min_size=1, max_size=4).map(tuple)


@pytest.mark.parametrize(
    ("path", "names"),
    [
        (("image.jpg",), ["image.jpg", "image%2Ejpg"]),
        (("my photos", "a ball.jpg"), ["my%20photos.a%20ball.jpg", "my%20photos.a%20ball%2Ejpg"]),
        (("conf.d", "x"), ["conf%2Ed.x", "conf%2Ed.x"]),
        (("a..b",), ["a%2E%2Eb"]),
        (("notes.meta",), ["notes%2Emeta"]),
        (("meta",), []),
        (("é",), ["%C3%A9", "%C3%A9"]),
        (("x" * 256,), []),
        (("a.b" * 20,), [".".join(["a", *["ba"] * 19, "b"]), "a%2Eb" * 20]),
        (tuple("abcdefgh" * 5), []),
    ],
)  # fmt: skip
def test_a_file_has_these_names(path: tuple[str, ...], names: list[str]) -> None:
    assert list(names_of(path)) == names


@pytest.mark.parametrize(
    "name",
    [
        "%2E%2E",
        "%2E",
        "%2E%2E.%2E%2E.etc.passwd",
        "%2E%2E%2Fetc%2Fpasswd",
        "%2Fetc%2Fpasswd",
        "photos.%2E%2E.%2E%2E",
        "photos%2Fball.jpg",
        "a%5Cb",
        "a%00b",
        "a%0Ab",
        "a%7Fb",
        "a%C2%85b",
        "C%3A",
        "c%3Awindows",
        "%2Ehidden",
        "photos.%2Ehidden",
        "%2Ertkit-upload-1",
        "x" * 256,
        "%C3%A9" * 128,
    ],
)
def test_no_file_is_called_that(name: str) -> None:
    with pytest.raises(PropertyError) as caught:
        path_of(name, {("photos",)})
    assert caught.value.code == "denied"


def test_escapes_of_escapes_are_what_they_say() -> None:
    assert path_of("%252E%252E", set()) == ("%2E%2E",)
    assert path_of("%252Fetc", set()) == ("%2Fetc",)


def test_the_deepest_directory_takes_it() -> None:
    there = {("a",), ("a", "b"), ("x.y",)}
    assert path_of("a.b.c.d", there) == ("a", "b", "c.d")
    assert path_of("a.b", there) == ("a", "b")
    assert path_of("b.c", there) == ("b.c",)
    assert path_of("x%2Ey.z", there) == ("x.y", "z")
    assert path_of("x.y.z", there) == ("x.y.z",)


def test_hidden_files_are_seen_where_that_is_wanted() -> None:
    assert path_of("%2Eprofile", set(), hidden=True) == (".profile",)
    with pytest.raises(PropertyError):
        path_of("%2E%2E", set(), hidden=True)


@given(PATHS)
def test_a_name_leads_back_to_its_file(path: tuple[str, ...]) -> None:
    directories = {path[:end] for end in range(1, len(path))}
    for name in names_of(path):
        assert path_of(name, directories) == path


@given(some.lists(some.sampled_from(["a", ".", "..", "%2E", "%2F", "/", "\\", "%00", "é", "%5C"])))
def test_no_spelling_leads_outside(parts: list[str]) -> None:
    for name in ("".join(parts), ".".join(parts)):
        try:
            path = path_of(name, {("a",), ("a", "a")})
        except PropertyError:
            continue
        assert all(part not in ("", ".", "..") and "/" not in part for part in path)
        assert not any("\0" in part or "\\" in part for part in path)
