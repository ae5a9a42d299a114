"""Line protocol over serial lines: client, endpoint, and what both share."""
