"""Settings of a manager and its components: rtc.conf, options, properties."""
