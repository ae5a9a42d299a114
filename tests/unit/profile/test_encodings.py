"""The same document in every dress that XML allows."""

from __future__ import annotations

import pytest

from rtkit.profile.read import read_rts
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.write import write_rts

RTS = "http://www.openrtp.org/namespaces/rts"
BODY = f"""<rts:RtsProfile xmlns:rts="{RTS}" xmlns:rtsExt="{RTS}_ext" rts:id="日本語の系"
    rts:version="0.2" rts:creationDate="2020-01-01T00:00:00"
    rts:updateDate="2020-01-01T00:00:00" rts:abstract="一行目&#10;二行目&#9;タブ">
  <rtsExt:VersionUpLogs>第一版
改行</rtsExt:VersionUpLogs>
</rts:RtsProfile>
"""
EXPECTED = RtsProfile(
    "日本語の系",
    "0.2",
    "2020-01-01T00:00:00",
    "2020-01-01T00:00:00",
    "一行目\n二行目\tタブ",
    version_up_logs=("第一版\n改行",),
)


def read(data: bytes) -> RtsProfile:
    reading = read_rts(data, strict=True)
    assert reading.notes == ()
    return reading.profile


@pytest.mark.parametrize(
    ("declared", "codec"),
    [
        ("UTF-8", "utf-8"),
        ("UTF-8", "utf-8-sig"),
        ("UTF-16", "utf-16"),
        ("UTF-16LE", "utf-16-le"),
        ("UTF-16BE", "utf-16-be"),
        ("Shift_JIS", "shift_jis"),
        ("EUC-JP", "euc_jp"),
        ("ISO-2022-JP", "iso2022_jp"),
    ],
)
def test_declared_encodings(declared: str, codec: str) -> None:
    text = f'<?xml version="1.0" encoding="{declared}"?>\n{BODY}'
    assert read(text.encode(codec)) == EXPECTED


@pytest.mark.parametrize("codec", ["utf-8", "utf-8-sig", "utf-16"])
def test_undeclared_encodings(codec: str) -> None:
    assert read(BODY.encode(codec)) == EXPECTED


def test_carriage_returns() -> None:
    assert read(BODY.replace("\n", "\r\n").encode()) == EXPECTED


def test_cdata_comments_and_instructions() -> None:
    text = BODY.replace(
        "第一版\n改行", "<![CDATA[第一]]>版<!-- < --><?x y?><![CDATA[\n]]>改<!--x-->行"
    )
    text = text.replace("  <rtsExt", "<!-- between --><?pi?>\n<rtsExt")
    text = f"<?xml version='1.0'?><!-- before --><?pi?>{text}<!-- after -->"
    assert read(text.encode()) == EXPECTED


def test_what_is_written_keeps_every_character() -> None:
    comment = "a\"b'c<d>&e\n\r\n\tf 日本 \U0001f916 ]]> "
    profile = RtsProfile(
        "i",
        "0.2",
        "2020-01-01T00:00:00",
        "2020-01-01T00:00:00",
        comment,
        comment,
        version_up_logs=(comment, " ", "", "\r"),
    )
    written = write_rts(profile)
    assert read(written) == profile
    assert b"&#13;&#10;&#9;f" in written
    assert "日本".encode() in written
