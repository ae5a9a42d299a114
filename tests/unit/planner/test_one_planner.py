"""One planner object solves a deployment and a manipulation; it knows neither world."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest
from deployments import model_from
from pagekit import ROOT
from reference_model import problem_of

sys.path.insert(0, str(ROOT / "examples"))

from manipulation import spar, take

from rtkit import planner
from rtkit.deployment.planning import decide
from rtkit.deployment.planning.deployment_plan import make_plan
from rtkit.planner import Evaluator, OneOf, plan, verify

FILE = json.loads((ROOT / "tests/unit/deployment/planning/instances.json").read_text())


def test_one_planner_solves_a_deployment_and_a_manipulation():
    evaluator = Evaluator()
    model = model_from(FILE["instances"]["bring-up"], FILE["default_costs"])
    deployment = problem_of(model)
    wished = {
        variable: OneOf(model.units[variable[4:]].places if wish == "*" else [*words(wish)])
        for variable, wish in model.desired.items()
    }
    brought_up = evaluator.leg(deployment, deployment.names, wished)(deployment.start)
    assert brought_up.cost == make_plan(model).cost == 35
    assert (evaluator.asked, evaluator.evaluations) == (1, 1)

    held = spar.spar((2, 2, 1), (3, 3, 0), move=2, rotate=3)
    assert evaluator.leg(held, held.names, held.goal)(held.start).cost == 11
    site = take.doorway_site(evaluator)
    assert take.pass_doorway(site, bounded=True)(site.state).cost == 39
    again = evaluator.leg(deployment, deployment.names, wished)(deployment.start)
    assert again == brought_up
    assert evaluator.asked - evaluator.evaluations >= 1


@pytest.mark.parametrize("ties", ["first", "any"])
@pytest.mark.parametrize("name", FILE["instances"])
def test_the_search_of_the_library_finds_what_deployments_cost(name, ties):
    model = model_from(FILE["instances"][name], FILE["default_costs"])
    problem = problem_of(model)
    found = plan(problem, ties=ties)
    assert (found.cost, verify(problem, found)) == (make_plan(model).cost, "")
    assert decide.plan is planner.plan, "rtplan searches with this very function"


def words(wish):
    return [wish] if isinstance(wish, str) else wish


PLAIN = """
import sys
from manipulation import explore, large, line, spar, take
print(sorted(name for name in sys.modules if name.startswith("rtkit.")))
before = set(sys.modules)
import rtkit.deployment.planning.deployment_plan
print(sorted(name for name in set(sys.modules) - before if not name.startswith("rtkit.")))
"""


def test_a_manipulation_loads_nothing_of_deployments_nor_the_reverse():
    done = subprocess.run(
        [sys.executable, "-c", PLAIN],
        cwd=ROOT / "examples",
        capture_output=True,
        text=True,
        check=True,
    )
    loaded, others = map(eval, done.stdout.splitlines())
    assert {name.split(".")[1] for name in loaded} <= {"planner", "errors", "fast_dataclass"}
    assert not [name for name in others if "manipulation" in name]
