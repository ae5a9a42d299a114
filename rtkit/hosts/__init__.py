"""Other hosts: the inventory, connections over SSH, links between the routers of managers."""
