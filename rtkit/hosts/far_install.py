"""Program that makes a version of rtkit on a host, or tells which wheels it lacks for that.

It is sent as text to the interpreter there, under any Python 3. Its argument is JSON: ``id`` of the
version, ``wheels`` by name with their SHA-256, ``mark`` that begins its answer, and whether the
version ``is_damaged``, if it is there. A version is a virtual environment, in which wheels are
unpacked as the format of wheels says. It is made beside its place, and renamed when all is there;
so is the link ``current``. Versions that nothing uses are removed then, but for the last one. Lines
before its answer tell what it does.
"""

import configparser
import contextlib
import fcntl
import glob
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile

_COMPLETE = "rtkit-complete"
_LOCK_S = 120.0
_SCRIPT = "#!%s -P\nimport sys\nfrom %s import %s\nsys.exit(%s())\n"


def _digest(path: str) -> str:
    try:
        with open(path, "rb") as file:
            return hashlib.sha256(file.read()).hexdigest()
    except OSError:
        return ""


def _size(path: str) -> int:
    try:
        return os.stat(path).st_size
    except OSError:
        return 0


def _report(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def _take(lock: int) -> None:
    """Wait until nobody else makes a version; who lost his connection may still be at it."""
    until = time.monotonic() + _LOCK_S

    def report_waiting(*_: object) -> None:
        if time.monotonic() > until:
            raise SystemExit("another command makes a version there")
        _report("waiting for another command")

    signal.signal(signal.SIGALRM, report_waiting)
    signal.setitimer(signal.ITIMER_REAL, 0.5, 10.0)
    fcntl.lockf(lock, fcntl.LOCK_EX)
    signal.setitimer(signal.ITIMER_REAL, 0)


def _program(path: str, text: str) -> None:
    with open(path, "w") as file:
        file.write(text)
    os.chmod(path, 0o755)


def _unpack(wheel: str, folder: str, site: str, python: str) -> None:
    """Put the files of a wheel where they belong; with the programs that it names."""
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
        top = {name.split("/")[0] for name in archive.namelist()}
    places = {"data": folder, "purelib": site, "platlib": site, "headers": folder}
    for data in (name for name in top if name.endswith(".data")):
        for part, place in places.items():
            source = os.path.join(site, data, part)
            if os.path.isdir(source):
                shutil.copytree(source, place, dirs_exist_ok=True)
        for path in glob.glob(os.path.join(site, data, "scripts", "*")):
            with open(path, encoding="utf-8", errors="surrogateescape") as file:
                text = file.read()
            if text.startswith("#!python"):
                text = "#!" + python + text[text.index("\n") :]
            _program(os.path.join(folder, "bin", os.path.basename(path)), text)
        shutil.rmtree(os.path.join(site, data))
    for info in (name for name in top if name.endswith(".dist-info")):
        points = configparser.ConfigParser(delimiters=("=",), interpolation=None)
        points.optionxform = str  # type: ignore[assignment,method-assign]
        points.read(os.path.join(site, info, "entry_points.txt"), encoding="utf-8")
        if points.has_section("console_scripts"):
            for name, target in points.items("console_scripts"):
                module, _, function = target.split("[")[0].strip().partition(":")
                words = (python, module, function.split(".")[0], function)
                _program(os.path.join(folder, "bin", name), _SCRIPT % words)


def _install(wanted: dict, folder: str, wheels: str) -> None:  # type: ignore[type-arg]
    """Make the environment, and rename it; the mark of completeness tells what is in it."""
    draft, former = folder + ".draft", folder + ".damaged"
    for each in (draft, former):
        shutil.rmtree(each, ignore_errors=True)
    words = [sys.executable, "-m", "venv", "--without-pip", draft]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        lines = done.stdout.decode("utf-8", "replace").strip().splitlines()
        raise SystemExit("cannot run python -m venv: " + " ".join(lines[-3:]))
    for name in [os.path.join("bin", each) for each in os.listdir(os.path.join(draft, "bin"))]:
        if not os.path.islink(os.path.join(draft, name)):
            _replace(os.path.join(draft, name), draft, folder)
    _replace(os.path.join(draft, "pyvenv.cfg"), draft, folder)
    (site,) = glob.glob(os.path.join(draft, "lib", "python3*", "site-packages"))
    for number, name in enumerate(sorted(wanted["wheels"])):
        _report(
            " ".join(["installing", str(number), str(len(wanted["wheels"])), name.split("-")[0]])
        )
        _unpack(os.path.join(wheels, name), draft, site, os.path.join(folder, "bin", "python"))
    os.sync()  # the mark is not to outlive a power failure that the files do not
    files = _files(draft)
    with open(os.path.join(draft, _COMPLETE), "w") as file:
        json.dump(files, file)
    if os.path.exists(folder):
        os.rename(folder, former)  # a manager that runs with it keeps what it has open
    os.rename(draft, folder)


def _replace(path: str, old: str, new: str) -> None:
    with open(path, "rb") as file:
        data = file.read()
    with open(path, "wb") as file:
        file.write(data.replace(old.encode(), new.encode()))


def _files(folder: str) -> dict:  # type: ignore[type-arg]
    """Return size and time of change of all files in a folder, by their paths in it."""
    found = {}
    for top, _, names in os.walk(folder):
        for path in (os.path.join(top, each) for each in names):
            if not os.path.islink(path):
                status = os.stat(path)
                found[os.path.relpath(path, folder)] = [status.st_size, status.st_mtime_ns]
    return found


def _used(folder: str) -> bool:
    """Return whether a process has files of a version mapped; those of others do not tell."""
    for path in glob.glob("/proc/[0-9]*/maps"):
        with contextlib.suppress(OSError), open(path, errors="replace") as file:
            if folder + "/" in file.read():
                return True
    return False


def _use(base: str, wanted: str) -> list:  # type: ignore[type-arg]
    """Have a version in use; return those that are removed."""
    link = os.path.join(base, "current")
    former = os.path.basename(os.readlink(link)) if os.path.islink(link) else ""
    if former != wanted:
        draft = link + ".draft"
        with contextlib.suppress(FileNotFoundError):
            os.unlink(draft)
        os.symlink(os.path.join("versions", wanted), draft)
        os.replace(draft, link)
    versions = os.path.realpath(os.path.join(base, "versions"))
    removed = [
        each
        for each in os.listdir(versions)
        if each not in (wanted, former) and not _used(os.path.join(versions, each))
    ]
    for each in removed:
        shutil.rmtree(os.path.join(versions, each), ignore_errors=True)
    return removed


def _make(wanted: dict, base: str) -> dict:  # type: ignore[type-arg]
    wheels = os.path.join(base, "wheels")
    for folder in (wheels, os.path.join(base, "versions")):
        os.makedirs(folder, mode=0o700, exist_ok=True)
    folder = os.path.join(base, "versions", wanted["id"])
    with open(os.path.join(base, "lock"), "w") as lock:
        _take(lock.fileno())
        is_complete = os.path.exists(os.path.join(folder, _COMPLETE)) and not wanted["is_damaged"]
        lacking = {
            name: _size(os.path.join(wheels, name + ".part"))
            for name, digest in wanted["wheels"].items()
            if not is_complete and _digest(os.path.join(wheels, name)) != digest
        }
        removed: list = []  # type: ignore[type-arg]
        if not lacking:
            if not is_complete:
                _install(wanted, folder, wheels)
            removed = _use(base, wanted["id"])
            for name in set(os.listdir(wheels)) - set(wanted["wheels"]):
                os.unlink(os.path.join(wheels, name))  # the others are not sent for the next one
    made = not is_complete
    return {"wheels": wheels, "lacking": lacking, "made": made, "removed": removed}


def main() -> None:
    """Be the program."""
    wanted = json.loads(sys.argv[1])
    try:
        found = _make(wanted, os.path.join(os.path.expanduser("~"), ".local", "share", "rtkit"))
    except OSError as error:
        where = ": " + str(error.filename) if error.filename else ""
        raise SystemExit((error.strerror or str(error)) + where) from None
    _report(wanted["mark"] + json.dumps(found))


if __name__ == "__main__":
    main()
