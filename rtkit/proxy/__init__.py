"""Proxy: carries calls and events between any two endpoints, without a look at values."""
