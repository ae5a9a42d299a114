from types import CodeType

import pytest
from openrtm_corpus import COMPONENTS, needs_components, sources

from rtkit.errors import Refused
from rtkit.openrtm.migrate.age_hint import age_hint
from rtkit.openrtm.migrate.python2 import is_python2_error, sign_of_python2
from rtkit.openrtm.migrate.source import compiled, declared_encoding, mended

MIXED = b'def f():\n\ttext = """a\n\tb"""\n        return text\n'


def test_a_source_that_compiles_is_returned_as_it_is():
    source = "# -*- coding: euc-jp -*-\nname = '日本'\n".encode("euc_jp")
    assert mended(source, "a.py") is source


def test_mixed_tabs_count_to_columns_of_eight_and_texts_keep_theirs():
    names: dict[str, object] = {}
    exec(mended(MIXED, "a.py"), names)
    assert names["f"]() == "a\n\tb"  # type: ignore[operator]


@pytest.mark.parametrize("encoding", ["euc_jp", "cp932"])
def test_an_encoding_that_is_not_declared_is_found(encoding):
    names: dict[str, object] = {}
    exec(mended("name = '日本語の名前'\n".encode(encoding), "a.py"), names)
    assert names["name"] == "日本語の名前"


def test_a_wrong_declaration_is_replaced_and_no_line_moves():
    source = "#!/usr/bin/env python\n# -*- coding: utf-8 -*-\nx = '日本'\ny = 1\n".encode("cp932")
    lines = mended(source, "a.py").decode().split("\n")
    assert lines[1] == "# -*- coding: utf-8 -*-"
    assert lines[2:4] == ["x = '日本'", "y = 1"]


def test_a_declaration_that_is_right_stays_where_tabs_are_mended():
    source = "# coding: cp932\ndef f():\n\tx = '表'\n        return x\n".encode("cp932")
    assert declared_encoding(mended(source, "a.py")) == "cp932"
    names: dict[str, object] = {}
    exec(mended(source, "a.py"), names)
    assert names["f"]() == "表"  # type: ignore[operator]


@pytest.mark.parametrize(
    ("source", "what"),
    [
        ("print 'a'\n", "print as a statement"),
        ("try:\n    f()\nexcept OSError, e:\n    pass\n", "except with a comma"),
        ("raise ValueError, 'x'\n", "raise with a comma"),
        ("x = 10L\n", "a long number"),
        ("x = 0755\n", "an octal number without o"),
        ("if a <> b: pass\n", "<> for !="),
        ("x = `y`\n", "backquotes"),
        ("exec 'a = 1' in {}\n", "exec as a statement"),
    ],
)
def test_python_2_is_refused_with_the_command_that_converts_it(source, what):
    with pytest.raises(Refused) as caught:
        mended(source.encode(), "dir/Old.py")
    assert f"is Python 2 ({what})" in str(caught.value)
    assert str(caught.value).endswith("rtkit openrtm migrate dir/Old.py converts it")


def test_the_sign_nearest_to_the_error_is_named():
    text = "print 'a'\n" + "pass\n" * 10 + "raise E, 'x'\n"
    assert sign_of_python2(text, 12) == (12, "raise with a comma")


def test_printing_to_a_file_is_a_sign_though_it_compiles():
    assert sign_of_python2("x = 1\nprint >>f, x\n") == (2, "print as a statement")


def test_what_is_in_texts_and_comments_is_no_sign():
    assert sign_of_python2("# print 'a'\nx = '''\nprint 1\n'''\n") is None


def test_compiling_mends_only_what_does_not_compile():
    sources = []

    def compile_source(file: str, source: bytes) -> CodeType:
        sources.append(source)
        return compile(source, file, "exec")

    assert compiled("a.py", MIXED, compile_source).co_filename == "a.py"
    assert sources == [MIXED, mended(MIXED, "a.py")]
    compiled("b.py", b"x = 1\n", compile_source)
    assert sources[2:] == [b"x = 1\n"]


def test_a_source_of_no_python_keeps_its_error():
    with pytest.raises(SyntaxError) as caught:
        mended(b"def f(:\n    pass\n", "a.py")
    assert caught.value.lineno == 1


def test_a_null_byte_is_an_error_of_syntax():
    with pytest.raises(SyntaxError):
        mended(b"x = 1\0\n", "a.py")


def test_a_byte_order_mark_stays():
    source = b"\xef\xbb\xbf" + MIXED
    assert mended(source, "a.py").startswith(b"\xef\xbb\xbf")


def test_errors_of_python_2_names_are_known():
    with pytest.raises(NameError) as caught:
        exec("raw_input()", {})
    assert is_python2_error(caught.value) == "raw_input"
    with pytest.raises(ModuleNotFoundError) as missing:
        exec("import ConfigParser", {})
    assert is_python2_error(missing.value) == "module ConfigParser"
    assert is_python2_error(NameError("x", name="mine")) == ""
    with pytest.raises(TypeError) as caught_type:
        exec("[None] * (4 / 2)", {})
    assert is_python2_error(caught_type.value) == "/ between whole numbers"
    assert age_hint(missing.value, "A.py") == (
        ": module ConfigParser is Python 2, which rtkit openrtm migrate A.py converts"
    )
    assert age_hint(ValueError("x"), "A.py") == ""


@needs_components
def test_every_existing_component_is_mended_or_named_as_python_2():
    outcomes: dict[str, list[str]] = {}
    for file in sources():
        source, name = file.read_bytes(), str(file.relative_to(COMPONENTS))
        try:
            kind = "as it is" if mended(source, name) is source else "mended"
        except Refused:
            kind = "python 2"
        outcomes.setdefault(kind, []).append(name)
    assert len(outcomes["mended"]) >= 6
    assert len(outcomes["python 2"]) >= 10
