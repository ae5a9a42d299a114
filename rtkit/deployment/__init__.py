"""System deployment as facts: the wanted system, the live one, their differences, and the plan."""
