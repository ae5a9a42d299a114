"""Property Service: exchange of GET and SET between a client and the owner of a property."""
