"""What a manager and its components are told from outside: rtc.conf, options, properties."""
