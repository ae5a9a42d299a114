"""What a shell asks while a line is being typed: completion, and the functions that ask for it."""
