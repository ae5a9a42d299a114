"""The line protocol over unix sockets and TCP: client, endpoint, and what both share."""
