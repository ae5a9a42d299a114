"""The two components: one without a table, one without a site."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from manipulation.Manipulator import Manipulator
from manipulation.orders import Order
from manipulation.Supervisor import Supervisor

from rtkit.errors import Refused
from rtkit.testing import Trial

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.mark.parametrize("kind", [Manipulator, Supervisor])
def test_a_site_that_there_is_not_is_named(
    kind: type,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path))
    expected = pytest.raises(Refused, match=r"no such site: moon \(there is switch, doorway")
    with Trial(kind, {"conf.default.site": "moon"}) as trial, expected:
        trial.activate()
    assert "on_aborting failed" not in caplog.text


def test_the_manipulator_does_an_order_and_reports() -> None:
    with Trial(Manipulator, {"conf.default.speed": "0.5"}) as trial:
        trial.activate()
        trial.send("order", Order(1, "travel", 0.2, 0.1))
        trial.tick(30)
        reports = trial.received("felt")
        assert [reports[0].outcome, reports[-1].outcome] == ["busy", "done"]
        assert reports[-1].x == pytest.approx(0.2)


def test_the_supervisor_needs_no_numpy() -> None:
    code = "import sys, manipulation.Supervisor; sys.exit('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=EXAMPLES, timeout=50, check=False)
    assert done.returncode == 0
