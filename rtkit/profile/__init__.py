"""RTC and RTS profiles: models, XML reading and writing, schema validation.

Nothing is imported here, so that taking one model costs no more than that model:
`rtkit.profile.read`, `rtkit.profile.write`, `rtkit.profile.rts_model`, `rtkit.profile.rtc_model`,
`rtkit.profile.words`.
"""
