"""Line protocol over unix sockets and TCP: client, endpoint, and what both share."""
