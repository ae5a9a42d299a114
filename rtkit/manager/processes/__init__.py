"""The processes of a manager: how they begin, how they are heard, how their end is told."""
