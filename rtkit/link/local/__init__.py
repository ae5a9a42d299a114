"""Streams of port data, and calls of services, between two processes of one host: sockets."""
