"""Static check: checks a system before anything runs, each component against its RTC profile.

Nothing is imported here: `rtkit.static_check.check` checks a system, and
`rtkit.static_check.catalogue` holds the types of components.
"""
