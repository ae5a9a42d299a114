"""Planner: searches state spaces that are never built, for cheapest plans with proof.

It knows nothing of its domain: a state is a tuple of values, a command a function of it.
"""

from rtkit.planner.bounded import plan_within
from rtkit.planner.command import Command, Condition, State
from rtkit.planner.conflict import minimal_conflict
from rtkit.planner.costs import CostTable, Row
from rtkit.planner.functions import Evaluator, Function, Path, minimise
from rtkit.planner.order import Touch, layers, predecessors
from rtkit.planner.problem import OneOf, Problem
from rtkit.planner.replanning import Execution, Observation, execute
from rtkit.planner.result import Limits, OptimalPlans, Plan, Statistics, Step
from rtkit.planner.search import optimal_plans, plan
from rtkit.planner.sections import restrict, solved_in
from rtkit.planner.verify import verify

__all__ = [
    "Command",
    "Condition",
    "CostTable",
    "Evaluator",
    "Execution",
    "Function",
    "Limits",
    "Observation",
    "OneOf",
    "OptimalPlans",
    "Path",
    "Plan",
    "Problem",
    "Row",
    "State",
    "Statistics",
    "Step",
    "Touch",
    "execute",
    "layers",
    "minimal_conflict",
    "minimise",
    "optimal_plans",
    "plan",
    "plan_within",
    "predecessors",
    "restrict",
    "solved_in",
    "verify",
]
