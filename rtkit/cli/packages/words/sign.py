"""``rtpkg sign``: sign packages and bundles with the key of this user."""

from __future__ import annotations

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments


@command(
    "sign",
    is_local=True,
    examples=(
        ("rtpkg sign rtc_scale-1.0.0-py3-none-any.whl", "Before it is published."),
        ("rtpkg sign robot.rtbundle", "The profile in it, too."),
    ),
    arguments=("file",),
)
def main(app: App, files: tuple[str, ...] = arguments("WHEEL|BUNDLE...")) -> None:
    """Sign packages and bundles with the key of this user, an operator.

    rtkeys init makes such a key, rtkeys issue others. The signature is in the file, which is
    replaced as a whole: sign a wheel before it is published, as another one of that name is never
    replaced. Hosts that know the CA check it: rtpkg install --signed, or signed = true in
    rtkit.toml.
    """
    from rtkit.packages.bundle import is_bundle
    from rtkit.packages.bundle import sign as sign_bundle
    from rtkit.packages.signing import sign_wheel

    if not files:
        raise WrongArguments("takes wheels or bundles")
    for each in files:
        (sign_bundle if is_bundle(each) else sign_wheel)(each)
        app.verbose(f"{each} is signed")
