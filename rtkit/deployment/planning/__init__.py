"""The cheapest way from what lives to what is wanted: a deployment as a problem of planning."""
