"""Writes components of OpenRTM-aist-Python as native ones, idiom by idiom.

See decision 96.
"""
