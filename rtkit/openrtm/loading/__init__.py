"""Runs the modules of old components in this process, with the names that they import.

The loader of all modules begins in `module`; `names` tells where each name of OpenRTM is.
"""
