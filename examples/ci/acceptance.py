"""Brings a system up on this machine, looks whether it works, and takes it down.

python acceptance.py SYSTEM.xml PORT [--stand-in]
"""

import sys

import rtkit
from rtkit.errors import RtkitError


def main(file: str, port: str, *, stand_in: bool) -> int:
    """Return the exit status: 0 when the system came up and the port carried a value."""
    system = rtkit.load(file)
    for finding in system.check().findings:
        print(f"{file}:{finding.line}: {finding.severity}: {finding.text}")
    with rtkit.connect(start=True, notify=print) as tree:
        try:
            tree.apply_profile(system, rollback=True, stand_in=stand_in, transmit=True)
            tree.wait(port, timeout_s=10.0)
            print(f"{port} carries {tree.read(port)}")
            report = tree.check(system)
            print(report)
            return 0 if report else 1
        except RtkitError as error:
            print(f"failed: {error}")
            for entry in tree.logs(level="WARN", last=20):
                print(f"  {entry.component or entry.process}: {entry.message}")
            return 1
        finally:
            tree.teardown(system, end=True)
            tree.stop_manager()


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3], stand_in="--stand-in" in sys.argv))
