"""A home: robots, lights, storage and other standard services, led by a state machine."""
