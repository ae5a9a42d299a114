"""The vocabulary of the OMG RTC specification: enumerations, profile records, names, paths."""
