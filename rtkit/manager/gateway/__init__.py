"""Gateway of a manager for other hosts: requests over mutual TLS, as far as a role goes."""
