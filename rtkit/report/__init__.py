"""What a check found, in the forms that people and build servers read.

Nothing is imported here: `rtkit.report.finding` has the words, `rtkit.report.forms` writes them as
text, JSON, SARIF, JUnit or annotations of GitHub. Who checks what is no matter of this room.
"""
