"""The system that lives: its picture, and what may be done with it."""
