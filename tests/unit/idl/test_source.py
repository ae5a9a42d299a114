"""Included files, guards and macros; comments as documentation."""

from __future__ import annotations

import pytest

from rtkit.idl.comments import Comment, Comments
from rtkit.idl.read import read_idl
from rtkit.idl.source import IdlSource, InvalidIdl


def lines(text, **files):
    def find(name, _file):
        return (name, files[name]) if name in files else None

    source = IdlSource("a", text, find)
    return [line.text for line in source.lines if line.text.strip()], source


def test_guards_let_a_file_in_once():
    guarded = "#ifndef B\n#define B\nstruct B {};\n#endif\n"
    found, _ = lines('#include "b"\n#include <b>\nend', b=guarded)
    assert found == ["struct B {};", "end"]


def test_branches():
    text = "#define A\n#ifdef A\n1\n#else\n2\n#endif\n#if defined(A)\n3\n#endif\n"
    more = "#if !defined(A)\n4\n#else\n5\n#endif\n#if 0\n6\n#if 1\n7\n#endif\n#else\n8\n#endif\n"
    assert lines(text + more)[0] == ["1", "3", "5", "8"]
    assert lines("#undef A\n#define A\n#undef A\n#ifdef A\n1\n#endif\n2")[0] == ["2"]


def test_names_stand_for_values():
    assert lines("#define N 3\nlong a[N]; // N\nlong NN;")[0] == ["long a[3]; // 3", "long NN;"]


def test_directives_inside_comments_and_texts_are_none():
    text = (
        '/*\n#include "nothing"\n*/\nconst string S = "/*";\n#define A // "b\n#ifdef A\nx\n#endif'
    )
    found, source = lines(text)
    assert found[-1] == "x"
    assert source.missing == []


def test_directives_go_on_behind_a_backslash():
    assert lines("#if \\\n 0\nx\n#endif\ny")[0] == ["y"]


def test_pragmas_say_nothing():
    assert lines('#pragma prefix "acme"\n#ident "x"\n#\nx')[0] == ["x"]


def test_places_are_those_of_the_files():
    _, source = lines('\r\n#include "b"\r\nlast\r\n', b="\ufefffirst\n")
    assert source.text.split() == ["first", "last"]
    numbers = {line.text: str(line.place) for line in source.lines}
    assert (numbers["first"], numbers["last"]) == ("b:1", "a:3")
    assert str(source.place(99)) == "a:4"
    assert str(IdlSource("e", "#pragma x", lambda *_: None).place(1)) == ":1"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("#include x", 'a:1: #include needs "FILE" or <FILE>'),
        ("#define f(x) x", "a:1: #define is understood of plain names only: f(x) x"),
        ("\n#if A > 3\n#endif", "a:2: #if is understood of 0, 1 and defined(NAME): A > 3"),
        ("#if 1\n#elif 0\n#endif", "a:2: #elif is not understood"),
        ("#else", "a:1: #else without #if"),
        ("#endif", "a:1: #endif without #if"),
        ("#ifdef A\n", "a:2: #endif is missing"),
        ("#error no way", "a:1: #error no way"),
    ],
)
def test_what_is_not_understood_is_told(text, why):
    with pytest.raises(InvalidIdl) as caught:
        lines(text)
    assert str(caught.value) == why


def test_a_file_is_read_once():
    found, _ = lines('#include "b"\n#include "b"\nx', b='#include "b"\n#include "a"\ny')
    assert found == ["y", "x"]


def test_an_error_in_a_branch_that_is_left_out_is_none():
    assert lines("#if 0\n#error x\n#include y\n#if A > 3\n#endif\n#endif\nx")[0] == ["x"]


def said(text, line, end_line=None):
    found = [
        Comment(part[part.index("//") :], number, number)
        for number, part in enumerate(text.split("\n"), 1)
        if "//" in part
    ]
    return Comments(text.split("\n"), found).of(line, end_line or line)


def test_a_comment_belongs_to_what_follows_or_to_its_line():
    text = "// one\n// two\nlong a; //!< of a\nlong b; // of b\nlong c;"
    assert said(text, 3) == "one\ntwo"
    assert said(text, 4) == "of b"
    assert said(text, 5) == ""


@pytest.mark.parametrize(
    ("comment", "doc"),
    [
        ("/** Word. */", "Word."),
        ("/*!\n * @brief Word.\n *\n * More.\n * @param a b\n * Lost.\n */", "Word.\n\nMore."),
        ("/// \\brief A @c thing", "A thing"),
        ("/*=====*/", ""),
        ("//-----", ""),
        ("// a\ufffdb", ""),
        ("/* plain */", "plain"),
    ],
)
def test_marks_are_no_documentation(comment, doc):
    found = read_idl(f"{comment}\nstruct S {{ long n; }};")
    assert found.find("S").doc == doc
