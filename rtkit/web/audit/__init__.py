"""The record of what pages and scripts have changed."""
