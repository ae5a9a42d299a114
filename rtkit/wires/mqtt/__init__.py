"""Properties through an MQTT 5 broker: client, endpoint, and what both share."""
