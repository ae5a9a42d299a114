"""Sources from Python 2 to Python 3."""

from __future__ import annotations

import sys

import pytest
from openrtm_corpus import COMPONENTS, needs_components, sources

from rtkit.errors import Malformed, Refused
from rtkit.openrtm.migrate.source import mended
from rtkit.openrtm.migrate.to_python3 import ConvertedSource, converted


def convert(text: str) -> ConvertedSource:
    source = converted(text.encode(), "a.py")
    assert source is not None
    return source


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("print 'a', b\n", "print('a', b)\n"),
        ("try:\n    f()\nexcept E, e:\n    raise E, 'x'\n",
         "try:\n    f()\nexcept E as e:\n    raise E('x')\n"),
        ("x = raw_input('n: ')\n", "x = input('n: ')\n"),
        ("x = long(raw_input())\n", "x = int(input())\n"),
        ("import ConfigParser as C\nc = C.SafeConfigParser()\nc.readfp(f)\n",
         "import configparser as C\nc = C.ConfigParser()\nc.read_file(f)\n"),
        ("from ConfigParser import SafeConfigParser\nc = SafeConfigParser()\n",
         "from configparser import ConfigParser as SafeConfigParser\nc = SafeConfigParser()\n"),
        ("print >>sys.stderr, 'x'\n", "print('x', file=sys.stderr)\n"),
        ("import commands\nx = commands.getoutput('ls')\n",
         "import subprocess\nx = subprocess.getoutput('ls')\n"),
        ("import os\nx = os.getcwdu()\n", "import os\nx = os.getcwd()\n"),
        ("import string\nx = string.letters\n", "import string\nx = string.ascii_letters\n"),
        ("import string\nx = string.join([string.strip(s), 'a'], '_')\n",
         "import string\nx = '_'.join([s.strip(), 'a'])\n"),
        ("import string\nx = string.split(f(1), ',', 2)\ny = string.atoi('3', 8)\n",
         "import string\nx = f(1).split(',', 2)\ny = int('3', 8)\n"),
        ("from string import maketrans\nt = maketrans('a', 'b')\n",
         "maketrans = str.maketrans\nt = maketrans('a', 'b')\n"),
        ("import sys\nsys.setdefaultencoding('utf-8')\n", "import sys\npass\n"),
        ("async = 1\nprint async\n", "async_ = 1\nprint(async_)\n"),
        ("arg = [None] * ((len(RTC._d_TimedPose2D) - 4) / 2)\n",
         "arg = [None] * ((len(RTC._d_TimedPose2D) - 4) // 2)\n"),
        ("print 7 / 2, 7 / 2.0, a / 2\n", "print(7 // 2, 7 / 2.0, a / 2)\n"),
        ("print 'n', (len(x)  # how many / all\n       / 2)\n",
         "print('n', (len(x)  # how many / all\n       // 2))\n"),
        ("from __future__ import division\nprint 7 / 2\n",
         "\nprint(7 / 2)\n"),
        ("s = unicode(self.d.data, 'utf-8')\n",
         "s = (self.d.data if isinstance(self.d.data, str) else str(self.d.data, 'utf-8'))\n"),
        ("s = unicode(f(), 'utf-8')\n", "s = str(f(), 'utf-8')\n"),
        ("if d.has_key('a'): pass\n", "if 'a' in d: pass\n"),
        ("name = u'日本' if isinstance(x, unicode) else 3\n",
         "name = '日本' if isinstance(x, str) else 3\n"),
        ("print 1\r\nprint 2\r\n", "print(1)\nprint(2)\n"),
        ("print 1", "print(1)"),
        ("import sibling\nprint 1\n", "import sibling\nprint(1)\n"),
    ],
)  # fmt: skip
def test_python_2_becomes_python_3(before: str, after: str) -> None:
    source = convert(before)
    assert source.after == after
    assert converted(source.data, "a.py") is None, "it must not be converted twice"


@pytest.mark.parametrize(
    "text",
    [
        "print('a', 'b')\n",
        "x = 7 / 2\n",
        "try:\n    input = raw_input\nexcept NameError:\n    pass\n",
        "try:\n    import ConfigParser\nexcept ImportError:\n    import configparser\n",
        "import sys\nif sys.version_info[0] == 2:\n    import Queue\n",
        "def f(file, long=3):\n    return file, long\n",
        "from functools import reduce\nreduce(f, x)\n",
        "class P:\n    def has_key(self, k):\n        return self.has_key(k)\n",
        "def f():\n\tif a:\n\t\tpass\n                b()\n",
    ],
)
def test_python_3_and_what_is_for_both_stays(text: str) -> None:
    assert converted(text.encode(), "a.py") is None


def test_what_it_was_known_by_is_told() -> None:
    assert convert("x = 1\ny = long(x)\n").sign == (2, "long")
    assert convert("import urllib2\n").sign == (1, "module urllib2")
    assert convert("import sys\nprint >>sys.stderr, 'x'\n").sign == (2, "print as a statement")


def test_line_ends_and_encodings_stay() -> None:
    source = converted("# coding: cp932\r\nprint '表'\r\n".encode("cp932"), "a.py")
    assert source is not None
    assert source.data == "# coding: cp932\r\nprint('表')\r\n".encode("cp932")


def test_tabs_stay_where_they_may() -> None:
    assert convert("if a:\n\tprint 1\n").after == "if a:\n\tprint(1)\n"
    mixed = convert("if a:\n\tprint 1\n        print 2\n")
    assert (mixed.after, mixed.has_spaces) == ("if a:\n        print(1)\n        print(2)\n", True)


def test_what_a_person_should_look_at_is_told() -> None:
    remarks = convert("import imp\nprint a / 2\nx = y.encode('utf-8')\n").remarks
    assert [each.line for each in remarks] == [1, 2, 3]
    assert "may have divided whole numbers" in remarks[1].text


def test_what_is_no_python_is_refused_by_line() -> None:
    with pytest.raises(Malformed, match=r"SyntaxError: .* \(a.py:2\)"):
        converted(b"x = 1\ndef f(:\n", "a.py")
    with pytest.raises(Malformed, match=r"null bytes \(a.py:1\)"):  # Python tells no line here
        converted(b"x = \0\n", "a.py")


def test_what_cannot_be_converted_is_refused() -> None:
    with pytest.raises(Malformed, match=r"a\.py cannot be converted"):
        converted(b"print 1\ndef f(:\n    pass\n", "a.py")


def test_without_fissix_the_command_that_installs_it_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in [each for each in sys.modules if each.partition(".")[0] == "fissix"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "fissix", None)
    assert converted(b"x = 1\n", "a.py") is None, "who needs none is asked for none"
    with pytest.raises(Refused, match=r"fissix, .* not installed: pip install 'rtkit\[openrtm\]'"):
        converted(b"print 1\n", "a.py")


@needs_components
def test_every_existing_component_is_converted_once() -> None:
    count = 0
    for file in sources():
        name = str(file.relative_to(COMPONENTS))
        source = converted(file.read_bytes(), name)
        if source is not None:
            count += 1
            assert mended(source.data, name) is source.data
            assert converted(source.data, name) is None
    assert count >= 12
