"""Limits of slaves: what a host has, what processes use, what keeps them within."""
