"""Commands about packages of components."""
