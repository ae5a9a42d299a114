"""Modules of OpenRTM-aist that are run as scripts, in place of being loaded by a manager."""
