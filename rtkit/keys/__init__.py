"""Keys of users and hosts: a private CA, what it issued and revoked, and TLS made of them."""
