"""Takes the picture of a panel that `docs/howto/panels.md` shows: of its own example, in Chromium.

``python tools/make_panel_picture.py [FILE]``, docs/pictures/panel.png unless told otherwise.
"""

from __future__ import annotations

import os
import runpy
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "howto" / "panels.md"


def main(file: str = str(ROOT / "docs" / "pictures" / "panel.png")) -> None:
    """Serve the example of the page, and take its picture."""
    sys.path.insert(0, str(ROOT / "tests" / "support"))
    import browser

    with tempfile.TemporaryDirectory(prefix="rtk") as folder:
        os.environ |= {"RTKIT_RUNTIME_DIR": f"{folder}/run", "RTKIT_STATE_DIR": f"{folder}/state"}
        for each in ("run", "state"):
            os.mkdir(f"{folder}/{each}", 0o700)
        import rtkit
        from rtkit.link import secret

        example = Path(folder, "crane.py")
        example.write_text(PAGE.read_text("utf-8").split("```python\n")[1].split("```")[0], "utf-8")
        crane = runpy.run_path(str(example))["Crane"]
        with rtkit.serve(crane(), "home/crane", http=0, is_on_zenoh=False) as served:
            known = secret.read()
            with browser.opened(folder, known.user, known.password) as page:
                page.go(f"http://localhost:{served.http}/ps/home/crane")
                page.wait_for("document.querySelectorAll('rt-map li').length === 2")
                page.picture(file, 820, 980)


if __name__ == "__main__":
    main(*sys.argv[1:])
