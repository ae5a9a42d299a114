"""Page of ``rttop``: rates from metrics, their layout, the terminal that shows them."""
