"""What ``rttop`` shows: rates from figures, the page they make, the terminal it is shown on."""
