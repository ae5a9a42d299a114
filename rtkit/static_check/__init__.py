"""Systems checked before anything runs: each component against the RTC profile of its type.

Nothing is imported here: `rtkit.static_check.check` checks a system, and
`rtkit.static_check.catalogue` holds the types of components.
"""
