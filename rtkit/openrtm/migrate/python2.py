"""Recognises Python 2, in sources that do not compile and in errors of those that do."""

from __future__ import annotations

import re
from typing import NamedTuple

TOKEN = re.compile(
    r"#[^\n]*"
    r'|"""(?:[^\\]|\\.)*?"""'
    r"|'''(?:[^\\]|\\.)*?'''"
    r'|"(?:[^"\\\n]|\\.)*"'
    r"|'(?:[^'\\\n]|\\.)*'",
    re.DOTALL,
)
"""A comment or a text, in a source of any version."""
KEYWORD_AS_NAME = r"\basync\b(?![ \t]+(?:def|for|with)\b)|\bawait\b(?=[ \t]*(?:[=.,:)\]}]|$))"
"""A name that is a keyword since Python 3.7, in a source without comments and texts."""
_SIGNS = tuple(
    (re.compile(pattern, re.MULTILINE), what)
    for pattern, what in (
        (r"(?:^|[;:])[ \t]*print(?:[ \t]*>>|[ \t]+(?![=(.,\s])|[ \t]*$)", "print as a statement"),
        (r"(?:^|[;:])[ \t]*print[ \t]*\([^\n]*\)[ \t]*[%,]", "print as a statement"),
        (r"(?:^|[;:])[ \t]*exec[ \t]+[\w\"']", "exec as a statement"),
        (r"\bexcept[ \t]+[\w.]+[ \t]*,[ \t]*\w+[ \t]*:", "except with a comma"),
        (r"\bexcept[ \t]*\([^\n()]*\)[ \t]*,[ \t]*\w+[ \t]*:", "except with a comma"),
        (r"\braise[ \t]+[\w.]+[ \t]*,", "raise with a comma"),
        (r"`[^`\n]+`", "backquotes"),
        (r"<>", "<> for !="),
        (r"(?<![\w.])0[0-7]+(?![\w.])", "an octal number without o"),
        (r"(?<![\w.])(?:0[xX][0-9a-fA-F]+|\d+)[lL]\b", "a long number"),
        (r"\b[uU][rR](?=[\"'])", "a text with ur"),
        (r"\bdef[ \t]+\w+[ \t]*\([^\n]*\([ \t]*\w+[ \t]*,[^\n()]*\)", "a tuple as parameter"),
        (KEYWORD_AS_NAME, "async or await as a name"),
    )
)
RENAMED = frozenset(
    {
        "BaseHTTPServer", "CGIHTTPServer", "ConfigParser", "Cookie", "DocXMLRPCServer",
        "FileDialog", "HTMLParser", "Queue", "ScrolledText", "SimpleDialog", "SimpleHTTPServer",
        "SimpleXMLRPCServer", "SocketServer", "StringIO", "Tix", "Tkconstants", "Tkinter",
        "__builtin__", "_winreg", "cPickle", "cStringIO", "commands", "cookielib", "copy_reg",
        "dummy_thread", "htmlentitydefs", "httplib", "robotparser", "thread", "tkColorChooser",
        "tkCommonDialog", "tkFileDialog", "tkFont", "tkMessageBox", "tkSimpleDialog", "ttk",
        "urllib2", "urlparse", "xmlrpclib",
    }
)  # fmt: skip
"""Modules that have another name in Python 3."""
GONE = frozenset(
    {
        "apply", "basestring", "buffer", "cmp", "coerce", "execfile", "file", "intern", "long",
        "raw_input", "reduce", "reload", "unichr", "unicode", "xrange",
    }
)  # fmt: skip
"""Functions that Python 3 does not have, or not among its built-in names."""


_OF_DIVISIONS = ("non-int of type 'float'", "'float' object cannot be interpreted", "slice indices")
"""Parts of the errors where a quotient of whole numbers is to be one."""


class SignOfPython2(NamedTuple):
    """A place at which a source shows that it is Python 2."""

    line: int
    what: str


def sign_of_python2(text: str, line: int = 0) -> SignOfPython2 | None:
    """Return where a source that does not compile is plainly Python 2; None where it is not.

    The sign nearest to the line of the error is returned.
    """
    bare = without_texts(text)
    found = [
        SignOfPython2(bare.count("\n", 0, match.end()) + 1, what)
        for pattern, what in _SIGNS
        for match in pattern.finditer(bare)
    ]
    return min(found, key=lambda sign: abs(sign.line - line), default=None)


def is_python2_error(error: BaseException) -> str:
    """Return what in an error of a running source is Python 2's; empty where nothing is."""
    name = getattr(error, "name", None) or ""
    if isinstance(error, ModuleNotFoundError) and name in RENAMED:
        return f"module {name}"
    if isinstance(error, NameError) and name in GONE:
        return name
    if isinstance(error, TypeError) and any(each in str(error) for each in _OF_DIVISIONS):
        return "/ between whole numbers"
    if isinstance(error, AttributeError) and name in ("has_key", "iteritems", "itervalues"):
        return name
    return ""


def without_texts(text: str) -> str:
    """Return a source without comments, with empty texts; numbers of lines stay."""

    def blank(match: re.Match[str]) -> str:
        token = match[0]
        if token.startswith("#"):
            return ""
        return f"{token[0]}{chr(10) * token.count(chr(10))}{token[0]}"

    return TOKEN.sub(blank, text)
