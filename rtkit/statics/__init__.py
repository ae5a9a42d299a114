"""Systems checked before anything runs: each component against the RTC profile of its type.

Nothing is imported here: `rtkit.statics.check` checks, `rtkit.statics.catalogue` knows the types.
"""
