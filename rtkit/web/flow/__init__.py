"""Values that flow, what was logged, and what was before."""
