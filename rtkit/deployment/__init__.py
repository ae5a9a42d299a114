"""A system as facts: what is wanted, what lives, the difference, and the plan between them."""
