"""The first steps of the README, as tools/first_value.py takes them to be timed."""

from __future__ import annotations

from pathlib import Path

import first_value
import pytest

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
STEPS = [first_value.Step("install\n", ""), first_value.Step("a\nrtprint x\n", "42\n")]


def test_they_begin_with_the_installation_and_end_with_a_value() -> None:
    first, *_, last = first_value.steps(README)
    assert first.typed.startswith("python3 -m venv")
    assert (last.typed.splitlines()[-1][:7], last.shown) == ("rtprint", "42\n")
    with pytest.raises(ValueError, match="prints no value"):
        first_value.steps("```sh\nrtls\n```\n")


@pytest.mark.parametrize(
    ("parts", "status", "line"),
    [
        (["", "1001.0", "42\n", "1002.5", ""], 0, "first live value after 2.5 s, of 180"),
        (["", "1001.0", "42\n", "1182.5", ""], 1, "first live value after 182.5 s, of 180"),
        (["", "1001.0", "0\n", "1002.5", ""], 1, "it printed '0\\n', not '42\\n'"),
        (["", "1001.0", ""], 1, "a step failed"),
    ],
)
def test_what_is_told_of_them(parts: list[str], status: int, line: str, capsys: object) -> None:
    assert first_value._report(STEPS, 1000.0, parts) == status
    out = capsys.readouterr().out  # type: ignore[attr-defined]
    assert out.splitlines()[0] == "   1.0 s  install"
    assert out.splitlines()[-1] == line
