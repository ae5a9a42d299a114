"""Commands about other hosts."""
