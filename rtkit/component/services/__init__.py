"""Service ports, their interfaces, and calls between two of them."""
