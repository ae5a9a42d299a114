"""What is done with profiles as documents: judged, told, compared, drawn, begun.

All of it is pure: documents come in as bytes, pages and pictures go out as text. Nothing is
imported here.
"""
