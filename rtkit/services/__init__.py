"""Standard services of robots: mobile robot, sensor, vision, resource, group and others."""
