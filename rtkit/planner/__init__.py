"""Planner: searches state spaces that are never built, for cheapest plans with proof.

Theory of operation
-------------------
*A problem is data and functions.* A state is a tuple with one value for each variable, in the order
of the problem's variables. A command has conditions on a state and an effect from a state to the
next; a price says what that costs, always more than 0. `problem.Problem` ties variables with their
domains, a start, a goal, commands and costs together, and is never changed: `Problem.replaced` and
`sections.restrict` return others. The planner knows no domain. Deployments, manipulation tasks and
systems led from state to state all come as such problems, and no module here imports any of them.

*States are made on demand.* `Problem.successors` applies the commands that are possible in one
state. The product of the domains is never built: a search owns one table of the states that it has
met, and drops it with its result. Two searches share nothing, and no search keeps a clock, a file
or a thread; `Limits` bound the states expanded and the seconds.

*Two searches.* `search.plan` is A*: it expands states in the order of cost so far plus heuristic,
then of steps, until it knows the goals of least cost and fewest steps. `search.optimal_plans` goes
on until every cheapest way is known, and counts and lists them. `bounded.plan_within` lets a guess
that may be too high choose the next state, as long as a lower bound proves that the plan costs at
most a factor more than the cheapest; the plan carries what was proved.

*Why the heuristic must be consistent.* Then no closed state is ever met again at less cost, so each
is expanded once, and all cheapest ways of a state are known before a goal is closed. Consistency is
not believed: each step that is generated checks it, and a heuristic that breaks it raises
`Malformed` instead of yielding a plan that only looks cheapest.

*Why exact numbers.* With floats 0.1 + 0.2 costs more than 0.3, so plans of equal cost are no ties.
The search counts a float as the decimal that it shows, and sums integers or fractions.

*Same question, same plan.* Of the plans of least cost the one of fewest steps is returned, and of
those the one whose commands are offered first. That takes a look at every tie; who asks for
``ties="any"`` gets any of the cheapest, from no more states than a plain A* that prefers deep nodes
expands, and again the same one each time. Nothing depends on hashes or on time, except that a
limit of seconds may end a search early; then it raises `LimitReached` and never guesses.

*Three ends.* A plan; `Impossible`, after every state that can be reached was looked at; or
`LimitReached`, which leaves open what is possible. They differ in kind and exit status, for a user
does something else after each.

*What is built on it.* `sections` freezes variables, so that a whole plan becomes one command of a
problem above; `functions` composes such legs and plans equal ones once, by a key and a cache that
may be the caller's; `order` turns the sequence of a plan into layers of steps that need nothing of
each other; `conflict` finds the least part of what is desired that cannot be had together;
`replanning` carries a plan out and plans anew when the world differs.

*Invariants.* Each step of a plan begins in the state in which the one before ended; each of its
conditions holds there; no value leaves its domain and no frozen variable changes; the costs of the
steps add up to that of the plan. `verify.verify` checks all of these with none of the search's
code, and the laws compare the cost with that of a search through everything.
"""

from rtkit.planner.bounded import plan_within
from rtkit.planner.command import Command, Condition, State
from rtkit.planner.conflict import minimal_conflict
from rtkit.planner.costs import CostTable, Row
from rtkit.planner.functions import Alike, Evaluator, Function, Path, minimise
from rtkit.planner.order import Touch, layers, predecessors
from rtkit.planner.problem import OneOf, Problem
from rtkit.planner.replanning import Execution, Observation, execute
from rtkit.planner.result import Limits, OptimalPlans, Plan, Statistics, Step
from rtkit.planner.search import optimal_plans, plan
from rtkit.planner.sections import restrict, solved_in
from rtkit.planner.verify import verify

__all__ = [
    "Alike", "Command", "Condition", "CostTable", "Evaluator", "Execution", "Function", "Limits",
    "Observation", "OneOf", "OptimalPlans", "Path", "Plan", "Problem", "Row", "State", "Statistics",
    "Step", "Touch", "execute", "layers", "minimal_conflict", "minimise", "optimal_plans", "plan",
    "plan_within", "predecessors", "restrict", "solved_in", "verify",
]  # fmt: skip
