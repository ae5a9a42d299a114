"""Tools for profiles as documents: validating, summarising, comparing, drawing, creating.

All of it is pure: documents come in as bytes, pages and drawings go out as text. Nothing is
imported here.
"""
