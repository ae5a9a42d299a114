"""``rthost``: the inventory of hosts, a module for each word."""

from __future__ import annotations

from rtkit.cli.shared.group import group

_HELP = """Keep the inventory of other hosts, and look at them over SSH.

It is hosts.toml of the user (in XDG_CONFIG_HOME/rtkit, else ~/.config/rtkit); one in this folder
takes precedence over it, and one beside the system profile that a command reads over both. A host
needs sshd and Python; rtmgr start --host NAME does the rest. Of OpenSSH's own files
~/.ssh/config and /etc/ssh/ssh_config these keywords count: Host, Match (but exec: nothing is run),
Include, HostName, Port, User, IdentityFile, IdentitiesOnly, IdentityAgent, CertificateFile,
UserKnownHostsFile, GlobalKnownHostsFile, HostKeyAlias, HashKnownHosts, ProxyJump. Others that are
set for a host and decide about the way to it are named. RTKIT_SSH_CONFIG names another file
instead, as ssh -F does.
"""

main = group(
    "rthost",
    _HELP,
    ["add", "list", "check", "accept", "remove"],
    examples=(
        ("rthost add robot1 pi@192.168.1.7", "Know a host by a name."),
        ("rthost check", "Can all hosts be reached, and do they do?"),
    ),
)
