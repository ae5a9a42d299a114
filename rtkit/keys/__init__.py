"""Keys of users and hosts: a private CA, its certificates and revocations, and TLS made of them."""
