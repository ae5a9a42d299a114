"""``rtkeys``: keys and certificates for other users and hosts, a module for each word."""

from __future__ import annotations

from rtkit.cli.shared.group import group

_HELP = """Keep a private CA, which says who may come in from other hosts.

It lies in RTKIT_KEYS, else in rtkit/keys of the configuration folder, for this user alone. Whoever
is given a certificate puts its folder at that place: services of rtserve --tls and --https, and
commands with addresses as tcps:HOST:PORT/SERVICE.NAME, show what lies there.
"""

main = group(
    "rtkeys",
    _HELP,
    ["init", "issue", "list", "show", "revoke"],
    examples=(
        ("rtkeys init", "Make the CA, and a certificate of this user."),
        ("rtkeys issue anna --role viewer -o anna.keys", "A folder to hand over."),
    ),
)
