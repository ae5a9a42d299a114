"""Text of OpenSSH's configuration for one host, as paramiko can read it.

``Include`` is replaced by what it names, where its block counts for that host; keywords that do not
count are kept under names of their own, so that a look-up tells which were set.
"""

from __future__ import annotations

import glob
import os
import re
import shlex

from rtkit.errors import Malformed, NotFound
from rtkit.hosts.ssh_library import paramiko
from rtkit.settings.reading import read_private

HONOURED = (
    "Host",
    "Match",
    "Include",
    "HostName",
    "Port",
    "User",
    "IdentityFile",
    "IdentitiesOnly",
    "IdentityAgent",
    "CertificateFile",
    "UserKnownHostsFile",
    "GlobalKnownHostsFile",
    "HostKeyAlias",
    "HashKnownHosts",
    "ProxyJump",
)
"""Keywords of ``ssh_config`` that count."""

_IDLE = re.findall(
    r"\w+",
    """addkeystoagent batchmode checkhostip compression connecttimeout controlmaster controlpath
    controlpersist dynamicforward enableescapecommandline escapechar exitonforwardfailure
    forkafterauthentication forwardagent forwardx11 forwardx11timeout forwardx11trusted
    gatewayports gssapiauthentication gssapidelegatecredentials ignoreunknown ipqos localcommand
    localforward loglevel numberofpasswordprompts passwordauthentication permitlocalcommand
    pubkeyauthentication remotecommand remoteforward requesttty sendenv serveralivecountmax
    serveraliveinterval sessiontype setenv stdinnull syslogfacility tcpkeepalive tag tunnel
    updatehostkeys verifyhostkeydns visualhostkey xauthlocation""",
)
"""Keywords of the terminal and of forwarded ports: nothing of them is missed."""

_MATCHES = ("all", "canonical", "final", "host", "originalhost", "user", "localuser", "exec")
"""Words of ``Match`` that paramiko knows; the first three have no value."""
_LATER_ALL, _ALONE = re.compile(r"\b(final|canonical)\s+all\b"), r"\1"
"""``final all``, which paramiko refuses, means the same as ``final``."""
_MARK = "rtkit_"
_NEVER = "Host !*"
_DEEPEST = 16
_TOKENS = ["%C", "%d", "%h", "%L", "%l", "%n", "%p", "%r", "%u"]
_EXPANDED = ("identityfile", "identityagent", "certificatefile", "userknownhostsfile")


class _Config(paramiko.SSHConfig):
    TOKENS_BY_CONFIG_KEY = paramiko.SSHConfig.TOKENS_BY_CONFIG_KEY | dict.fromkeys(
        (*_EXPANDED, "hostkeyalias"), _TOKENS
    )


class ExpandedConfig:
    """Configuration of one host, to which files are added, the strongest first.

    Args:
        address: The host as it was named.
        given: Lines that count before all files.
    """

    def __init__(self, address: str, *given: str) -> None:
        self._address = address
        self._lines = ["Host *", *given]
        self._header = "Host *"
        self._unused: dict[str, str] = {}

    def add(self, path: str, base: str, above: tuple[str, ...] = ()) -> None:
        """Add a file, whose includes are relative to a folder; one that is not there is empty.

        Raises:
            Malformed: It cannot be read, tells file and line; or it includes itself.
            Refused: A stranger can have written it.
        """
        if path in above or len(above) >= _DEEPEST:
            raise Malformed(f"Include in a circle, or too deep: {' > '.join((*above, path))}")
        try:
            text = read_private(path, must_be_ours=True).decode("utf-8", "replace")
        except NotFound:
            return
        if not above:
            self._begin("Host *")
        for number, line in enumerate(text.splitlines(), 1):
            if (line := line.strip()) and not line.startswith("#"):
                found = re.match(paramiko.SSHConfig.SETTINGS_REGEX, line)
                if found is None:
                    raise Malformed(f"{path}:{number}: not KEYWORD VALUE: {line}")
                self._add_line(found[1], found[2], f"{path}:{number}", base, (*above, path))

    def lookup(self) -> tuple[dict[str, str | list[str]], tuple[str, ...]]:
        """Return the values by keyword in lower case, and what was set but does not count.

        Raises:
            Malformed: A line makes no sense.
        """
        found = self._lookup()
        unused = [text for mark, text in self._unused.items() if mark in found]
        return found, tuple(unused)

    def _add_line(
        self, keyword: str, value: str, where: str, base: str, above: tuple[str, ...]
    ) -> None:
        key = keyword.lower()
        if key == "match" and re.search(r"(^|\s)!?exec(\s|$)", value.lower()):
            self._begin("Host *")
            self._note(f"Match exec ({where}), of which nothing is run")
            self._begin(_NEVER)
        elif key == "match" and (alien := _alien(value)):
            self._begin("Host *")
            self._note(f"Match {alien} ({where}), which is taken for not met")
            self._begin(_NEVER)
        elif key in ("host", "match"):
            self._begin(f"{key} {_LATER_ALL.sub(_ALONE, value)}")
            if key == "match":
                self._lookup(where=where)
        elif key == "include":
            header = self._header
            if _MARK in self._lookup(f"{_MARK} here", where):
                for each in _named(value, base, where):
                    self.add(each, base, above)
                    self._begin(header)
        elif key in _HONOURED:
            self._lines.append(f"{key} {value}")
        elif key not in _IDLE and value.lower() != "none":
            self._note(f"{keyword} ({where})", value)

    def _begin(self, header: str) -> None:
        self._header = header
        self._lines.append(header)

    def _note(self, text: str, value: str = "is there") -> None:
        mark = f"{_MARK}{len(self._unused)}"
        self._unused[mark] = text
        self._lines.append(f"{mark} {value}")

    def _lookup(self, probe: str = "", where: str = "") -> dict[str, str | list[str]]:
        try:
            config = _Config.from_text("\n".join([*self._lines, probe]))
            return dict(config.lookup(self._address))
        except (paramiko.SSHException, ValueError) as error:
            raise Malformed(f"OpenSSH's configuration, {where or 'all of it'}: {error}") from error


_HONOURED = frozenset(each.lower() for each in HONOURED)


def _alien(value: str) -> str:
    """Return the first word of a ``Match`` that paramiko takes for met, empty if there is none."""
    try:
        words = iter(shlex.split(value))
    except ValueError:
        return ""  # the look-up tells
    for word in words:
        name = word.removeprefix("!")
        if name not in _MATCHES:
            return name
        if name not in _MATCHES[:3]:
            next(words, "")
    return ""


def expanded_path(text: str) -> str:
    """Return a path in which ``~`` and ``${VARIABLE}`` stand for what they mean."""
    text = re.sub(r"\$\{(\w+)\}", lambda found: os.environ.get(found[1], ""), text)
    return os.path.expanduser(text.replace("%%", "%"))


def _named(value: str, base: str, where: str) -> list[str]:
    """Return the files of an ``Include``, in order.

    Raises:
        Malformed: Its quotes do not match.
    """
    try:
        patterns = shlex.split(value)
    except ValueError as error:
        raise Malformed(f"{where}: Include: {error}") from None
    paths = (os.path.join(base, expanded_path(each)) for each in patterns)
    return [each for path in paths for each in sorted(glob.glob(path))]
