"""What a process that holds components does for them: the manager's own as well as a slave."""
