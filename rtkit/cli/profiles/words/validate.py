"""``rtprofile validate``: check profiles, and report all that is wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import click

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag, option, several, strict_option
from rtkit.cli.shared.profile_files import DocumentSource, sources
from rtkit.cli.shared.terminal import finding_style
from rtkit.errors import InvalidDocument, NotFound, UsageProblem
from rtkit.report.finding import Checked
from rtkit.report.forms import FORMS, JSON, TEXT, report_lines

TOOL = "rtprofile validate"


@command(
    "validate",
    is_local=True,
    examples=(
        ("rtprofile validate robot.xml", "Is it valid, and what had to be put right?"),
        ("rtprofile validate --strict profiles systems", "Whole folders, without forgiveness."),
        ("rtprofile validate --format sarif . > found.sarif", "For a code host or an editor."),
    ),
    json=("checked",),
)
def main(
    app: App,
    strict: None = strict_option("Take everything that needs repair for an error."),
    explain: bool = flag("--explain", "Have the schemas tell in full what is wrong; slow."),
    form: str = option(
        "--format", "How to tell (default text).", click.Choice(FORMS), default=TEXT
    ),
    is_json: bool = json_flag("The same as --format json."),
    ignored: tuple[str, ...] = several(
        "--ignore RULE",
        "Say nothing that is about this rule, but what nothing forgives; repeatable.",
    ),
    lists_rules: bool = flag("--rules", "List the rules."),
    quiet: bool = flag("-q --quiet", "Tell errors only."),
    paths: tuple[str, ...] = arguments("[FILE|FOLDER|-]..."),
) -> int:
    """Check profiles against the schemas, and against what no schema can tell.

    Files, all profiles below folders, or stdin (-, or nothing). Whatever could be put right is put
    right and noted, with its line and XPath, what stands there and what may; the exit status is 0.
    A fault that could not makes it 1. With --strict nothing is put right.
    """
    rules = _rules()
    if lists_rules:
        terminal.write(terminal.pairs(sorted(rules.items()), ""))
        return 0
    for rule in ignored:
        if rule not in rules:
            raise UsageProblem(f"no such rule: {rule}; --rules lists them")
    seen: list[Checked] = []
    judge = partial(_judge, strict=app.is_strict, ignored=ignored, is_explaining=explain)
    checked = _checked(app, paths, judge, seen)
    for line in report_lines(
        JSON if is_json else form, checked, rules, TOOL, style=finding_style, is_quiet=quiet
    ):
        click.echo(line)
    return _status(app, seen)


def _judge(
    source: DocumentSource, *, strict: bool, ignored: tuple[str, ...], is_explaining: bool
) -> Checked:
    from rtkit.profile_tools.validation import unreadable, validated

    if source.data is None:
        return unreadable(source.name, source.problem)
    return validated(
        source.data, source.name, strict=strict, ignored=ignored, is_explaining=is_explaining
    )


def _checked(
    app: App,
    paths: tuple[str, ...],
    judge: Callable[[DocumentSource], Checked],
    seen: list[Checked],
) -> Iterator[Checked]:
    """Yield the verdicts, and keep them in `seen`."""
    from rtkit.profile_tools.validation import may_be_profile

    for source in sources(paths):
        if source.data is not None and not source.is_named and not may_be_profile(source.data):
            app.verbose(f"{source.name}: no profile, skipped")
            continue
        seen.append(judge(source))
        yield seen[-1]
    if not seen:
        app.report(f"no profile below {', '.join(paths)}")


def _status(app: App, seen: list[Checked]) -> int:
    bad = [each for each in seen if not each.is_valid]
    if not bad:
        return 0
    return app.status(InvalidDocument() if any(each.is_read for each in bad) else NotFound())


def _rules() -> dict[str, str]:
    from rtkit.profile.rules import RULES
    from rtkit.profile_tools.validation import RULES as OTHER_RULES

    return RULES | OTHER_RULES
