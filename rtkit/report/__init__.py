"""Reports findings of checks in the forms that people and build servers read.

This package imports nothing: `rtkit.report.finding` has the model, `rtkit.report.forms` writes it
as text, JSON, SARIF, JUnit or annotations of GitHub. The checks themselves are elsewhere.
"""
