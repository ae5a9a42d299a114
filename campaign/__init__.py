"""Breaks a system of twenty components at random, again and again, and checks what comes of it."""
