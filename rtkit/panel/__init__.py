"""Panels of services in the terminal: what is drawn, how keys change it, and the service it is."""
