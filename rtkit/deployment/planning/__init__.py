"""Deployment planning: finds the cheapest plan from the live system to the wanted one."""
