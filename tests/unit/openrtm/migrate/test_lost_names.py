"""What older versions of Python had, in sources that are migrated."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.openrtm.migrate.to_python3 import ConvertedSource, converted


def convert(text: str) -> ConvertedSource:
    source = converted(text.encode(), "a.py")
    assert source is not None
    return source


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("import time\nx = time.clock()\n", "import time\nx = time.perf_counter()\n"),
        ("from time import sleep, clock\n", "from time import sleep, perf_counter as clock\n"),
        ("import inspect\nx = inspect.getargspec(f).args\n",
         "import inspect\nx = inspect.getfullargspec(f).args\n"),
        ("import inspect\na, b, c, d = inspect.getargspec(f)\n",
         "import inspect\na, b, c, d = inspect.getfullargspec(f)[:4]\n"),
        ("import collections\nx = collections.Mapping, collections.deque\n",
         "import collections.abc\nx = collections.abc.Mapping, collections.deque\n"),
        ("import collections as c\nx = c.Mapping\n",
         "import collections.abc, collections as c\nx = c.abc.Mapping\n"),
        ("from collections import deque, Mapping as M\n",
         "from collections.abc import Mapping as M; from collections import deque\n"),
        ("import dummy_threading\n", "import threading as dummy_threading\n"),
        ("from dummy_threading import Lock\n", "from threading import Lock\n"),
        ("import gettext\n_ = gettext.translation('a').ugettext\n",
         "import gettext\n_ = gettext.translation('a').gettext\n"),
        ("from xml import etree\nfor x in root.find('a').getchildren(): f(x)\n",
         "from xml import etree\nfor x in list(root.find('a')): f(x)\n"),
        ("async = f(a, async=True)\nself.async.x = '''async\n'''  # async\nprint(7 / 2)\n",
         "async_ = f(a, async_=True)\nself.async_.x = '''async\n'''  # async\nprint(7 / 2)\n"),
        ("if a:\n\tb = 1\n        await = 1\n",
         "if a:\n        b = 1\n        await_ = 1\n"),
    ],
)  # fmt: skip
def test_an_older_python_3_becomes_one_of_today(before: str, after: str) -> None:
    source = convert(before)
    assert (source.after, source.is_python2) == (after, False)
    assert converted(source.data, "a.py") is None, "it must not be converted twice"


@pytest.mark.parametrize(
    "text",
    [
        "try:\n    from collections.abc import Mapping\n"
        "except ImportError:\n    from collections import Mapping\n",
        "import sys, time\nif sys.version_info < (3, 3):\n    x = time.clock()\n",
        "string = 'a'\nimport string\nx = string.join(1)\n",
        "import collections, typing\nx = typing.Mapping\n",
        "async def f():\n    await g()\n    async with a as b: pass\n",
        "class T:\n    def clock(self): pass\n",
    ],
)
def test_what_a_source_guards_or_gives_itself_stays(text: str) -> None:
    assert converted(text.encode(), "a.py") is None


def test_what_cannot_be_mended_for_certain_is_left_and_told() -> None:
    source = convert("import threading, string, md5\nt.isAlive()\nstring.strip((a + b))\n")
    assert [each.line for each in source.remarks] == [1, 2, 3]
    assert "string.strip" in source.remarks[2].text
    source = convert("import imp\nimport threading\nt.isAlive()\n")
    assert (source.is_changed, source.is_python2) == (False, False)
    assert [each.line for each in source.remarks] == [1, 3]
    opened = convert("x = file('a')\nprint(x)\n")
    assert (opened.is_changed, opened.is_python2) == (False, True)
    assert opened.remarks == ((1, "file is Python 2"),)
    clock = convert("import time\nx = time.clock()\n")
    assert "processor time" in clock.remarks[0].text
    freed = convert("f(async=1)\nasync = other.async\n")
    assert [each.line for each in freed.remarks] == [1, 2]


def test_a_sibling_of_the_name_of_a_module_stays_one(tmp_path: Path) -> None:
    (tmp_path / "commands.py").touch()
    file = str(tmp_path / "a.py")
    text = "import commands\ncommands.go()\n"
    assert converted(text.encode(), file) is None
    source = converted(f"{text}print 1\n".encode(), file)
    assert source is not None
    assert source.after == f"{text}print(1)\n"


def test_siblings_in_a_package_get_a_dot(tmp_path: Path) -> None:
    for name in ("near", "far"):
        (tmp_path / f"{name}.py").touch()
    text = "import near as n, os\nfrom far import x\nfrom os import path\nimport far\n"
    file = str(tmp_path / "a.py")
    assert converted(text.encode(), file) is None
    source = converted(text.encode(), file, is_in_package=True)
    assert source is not None
    assert source.after == (
        "from . import near as n; import os\nfrom .far import x\nfrom os import path\n"
        "from . import far\n"
    )
