"""Program that makes a version of rtkit on a host, or tells which wheels it lacks for that.

It is sent as text to the interpreter there, under any Python 3. Its argument is JSON: ``id`` of the
version, ``wheels`` by name with their SHA-256, ``installs`` names what is installed. A version is a
virtual environment; the link ``current`` is put in its place by one rename, when all is there.
"""

import fcntl
import glob
import hashlib
import json
import os
import shutil
import subprocess
import sys

_COMPLETE = "rtkit-complete"


def _digest(path: str) -> str:
    try:
        with open(path, "rb") as file:
            return hashlib.sha256(file.read()).hexdigest()
    except OSError:
        return ""


def _run(*words: str) -> None:
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        lines = done.stdout.decode("utf-8", "replace").strip().splitlines()
        raise SystemExit("cannot run " + os.path.basename(words[0]) + ": " + " ".join(lines[-3:]))


def _install(wanted: dict, folder: str, wheels: str) -> None:  # type: ignore[type-arg]
    """Make the environment in its place; it counts only with the mark of completeness."""
    shutil.rmtree(folder, ignore_errors=True)
    _run(sys.executable, "-m", "venv", "--without-pip", folder)
    pip = glob.glob(os.path.join(wheels, "pip-*.whl"))[0]
    python = os.path.join(folder, "bin", "python")
    named = [os.path.join(wheels, name) for name in wanted["wheels"] if not name.startswith("pip-")]
    _run(python, pip + "/pip", "install", "-q", "--no-index", "--no-deps", "--no-compile", *named)
    with open(os.path.join(folder, _COMPLETE), "w") as file:
        file.write(wanted["id"])


def main() -> None:
    """Be the program."""
    wanted = json.loads(sys.argv[1])
    base = os.path.join(os.path.expanduser("~"), ".local", "share", "rtkit")
    wheels = os.path.join(base, "wheels")
    os.makedirs(os.path.join(base, "versions"), mode=0o700, exist_ok=True)
    os.makedirs(wheels, mode=0o700, exist_ok=True)
    folder = os.path.join(base, "versions", wanted["id"])
    with open(os.path.join(base, "lock"), "w") as lock:
        fcntl.lockf(lock, fcntl.LOCK_EX)
        is_complete = os.path.exists(os.path.join(folder, _COMPLETE))
        lacking = [
            name
            for name, digest in wanted["wheels"].items()
            if not is_complete and _digest(os.path.join(wheels, name)) != digest
        ]
        if not lacking and not is_complete:
            _install(wanted, folder, wheels)
        if not lacking:
            draft = os.path.join(base, "current." + str(os.getpid()))
            os.symlink(os.path.join("versions", wanted["id"]), draft)
            os.replace(draft, os.path.join(base, "current"))
            shutil.rmtree(wheels, ignore_errors=True)
    sys.stdout.write(json.dumps({"wheels": wheels, "lacking": lacking, "made": not is_complete}))


if __name__ == "__main__":
    main()
