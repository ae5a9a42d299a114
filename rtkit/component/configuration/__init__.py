"""Configuration of components: parameters, their kinds and constraints, and sets of them."""
