"""``rthost accept``: know the key of a host from now on."""

from __future__ import annotations

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments


@command(
    "accept",
    examples=(
        ("rthost accept robot1 SHA256:Ru5v", "Of this fingerprint, as rthost check told it."),
        ("rthost accept arm -h", "Tell more."),
    ),
    arguments=("known-host", "anything"),
)
def main(app: App, words: tuple[str, ...] = arguments("NAME FINGERPRINT")) -> None:
    """Have the key of a host be known, if it has this fingerprint.

    It is written to the first UserKnownHostsFile, where OpenSSH finds it, too. Compare the
    fingerprint with what the host itself shows: ssh-keygen -lf /etc/ssh/ssh_host_ed25519_key.pub
    """
    from rtkit.hosts import host_keys, inventory, ssh_config

    if len(words) != 2:
        raise WrongArguments("takes the name of a host, and the fingerprint of its key")
    name, fingerprint = words
    host = inventory.host(name)
    app.warn(ssh_config.remarks([host]))
    file = host_keys.accept(host, fingerprint, app.timeout_s)
    app.verbose(f"the key of {name} is in {file}")
